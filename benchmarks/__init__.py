"""How fast mpmkit is, against other programs, machines and its own parts; start it with ``python -m benchmarks``."""
