"""Makes pictures small: a PNG of at most 256 colours, which is all that text, charts and a few solids need.

.venv/bin/python -m tools.palette PNG ...
"""

from argparse import ArgumentParser
from io import BytesIO
from pathlib import Path

from PIL import Image

COLOURS = 256


def reduced(png: bytes, colours: int = COLOURS) -> bytes:
    """Return a PNG with at most that many colours, without transparency."""
    picture = Image.open(BytesIO(png)).convert("RGB")
    small = BytesIO()
    picture.quantize(colours, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    return small.getvalue()


if __name__ == "__main__":
    parser = ArgumentParser(prog="tools.palette", description="Reduce PNG files to 256 colours, in place.")
    parser.add_argument("picture", type=Path, nargs="+")
    for path in parser.parse_args().picture:
        path.write_bytes(reduced(path.read_bytes()))
