"""``python -m mpmkit`` is the command line."""

from mpmkit.cli import main

if __name__ == "__main__":
    main()
