"""Machinery of reading results back."""
