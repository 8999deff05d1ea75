"""A thick-walled cylinder under internal pressure: Lame's solution, axisymmetric and as a quarter in plane strain."""
