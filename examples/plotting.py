"""What the bar examples share: where pictures go, the table of our numbers beside the exact ones, the command line."""

import argparse
from pathlib import Path

HERE = Path(__file__).parent
IMAGES = HERE.parent / "docs" / "images"


def figure(width, height):
    """An empty figure in the look of the examples."""
    import matplotlib.pyplot as plt

    plt.style.use(HERE / "look.mplstyle")
    return plt.figure(figsize=(width, height))


def save(drawing, path):
    """Write a figure as a palette PNG: line drawings need few colours, and a gallery should load fast."""
    import io

    import matplotlib.pyplot as plt
    from PIL import Image

    buffer = io.BytesIO()
    drawing.savefig(buffer)
    plt.close(drawing)
    Image.open(buffer).convert("RGB").quantize(128).save(path, optimize=True)


def table(ours, exact):
    """Print our numbers beside the exact ones; a number without an exact partner stands alone."""
    width = max(map(len, ours))
    print(f"{'':{width}s}  {'ours':>12s}  {'exact':>12s}")
    for name, value in ours.items():
        partner = f"{exact[name]:12.6g}" if name in exact else ""
        print(f"{name:{width}s}  {value:12.6g}  {partner}".rstrip())


def start(main, check, exact, name):
    """Run an example from the command line: ``--output FOLDER`` for its picture, ``--quick`` for a shorter run."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--output", type=Path, default=IMAGES if IMAGES.is_dir() else Path(), help="folder of the picture")
    parser.add_argument("--quick", action="store_true", help="fewer particles, as in the tests")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    numbers = main(quick=options.quick, picture=options.output / f"{name}.png")
    table(numbers, exact)
    check(numbers)
    print("written:", options.output / f"{name}.png")
