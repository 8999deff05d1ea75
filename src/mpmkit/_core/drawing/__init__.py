"""Machinery of the pictures."""
