"""The picture that is kept: nothing that is told under it is cut off, and every contestant has its colour there."""

import io

import numpy as np
from PIL import Image

from tumble.lab.picture import captioned, error_text
from tumble.lab.pool import Contestant
from tumble.lab.readings import ErrorRow, Reading

SEEN = np.full((40, 60, 4), 255, dtype=np.uint8)
MINE = Contestant("./mine.py", "rk4", "mine")
OFF = ErrorRow(MINE, 3, np.zeros(3), np.full(3, 1e-3), 3**0.5 * 1e-3, 1e-15, "")


def picture(readings, rows) -> np.ndarray:
    """Return the picture's pixels, (h, w, 3)."""
    png = captioned(SEEN, (9, 9, 9), readings, rows, {MINE: (1, 200, 3)}, 2)
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def test_a_long_line_makes_the_picture_wider():
    pixels = picture([Reading("angular velocity", "rad/s", (-1e9, -2e9, 3e9)), Reading("mass", "kg", (1.0,))], [OFF])
    assert pixels.shape[1] > 2 * SEEN.shape[1]
    assert (pixels[SEEN.shape[0] :, -4:] == 255).all()
    assert (pixels[SEEN.shape[0] :] < 100).any()


def test_who_is_how_far_off_is_in_the_picture_with_the_colour_of_its_ghost():
    assert (picture([Reading("mass", "kg", (1.0,))], [OFF]) == (1, 200, 3)).all(axis=-1).any()
    assert not (picture([Reading("mass", "kg", (1.0,))], []) == (1, 200, 3)).all(axis=-1).any()


def test_who_is_not_there_says_why():
    assert error_text(OFF) == "mine:rk4: 0.00173 m, vertex 3"
    assert error_text(ErrorRow(MINE, None, None, None, np.nan, np.nan, "timeout")) == "mine:rk4: timeout"
    assert "at most 1e-15 m" in error_text(ErrorRow(MINE, 3, np.zeros(3), np.zeros(3), 0.0, 1e-15, ""))
