"""The picture on a board: its marks, drawn on an image."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.spec.mark import Mark

LONGER_SIDE = 512
"""Pixels of a picture's longer side."""
FINER = 3
"""Points per pixel and direction."""

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

FONT = bytes.fromhex(
    "0e11111f1111111e11111e11111e0e11101010110e1e11111111111e1f10101e10101f1f10101e1010100e11101711110f"
    "1111111f1111110e04040404040e0702020202120c111214181412111010101010101f111b151511111111191513111111"
    "0e11111111110e1e11111e1010100e11111115120d1e11111e1412110f10100e01011e1f0404040404041111111111110e"
    "11111111110a0411111115151b1111110a040a111111110a040404041f01020408101f0e11131519110e040c040404040e"
    "0e11010204081f1f02040201110e02060a121f02021f101e0101110e0608101e11110e1f0102040808080e11110e11110e"
    "0e11110f01020c"
)
"""Letters A to Z and figures 0 to 9 of 5 x 7 points: seven rows each, from the top, of five bits."""
LETTERS = {letter: FONT[7 * k : 7 * k + 7] for k, letter in enumerate("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789")}


def board_picture(size_m: tuple[float, float], ground: Sequence[float], marks: Sequence[Mark]) -> Floats:
    """Return the albedo (h, w, 3) of a board's front, seen from in front of it. ground: that of the board."""
    scale = LONGER_SIDE / max(size_m)
    width, height = (max(round(scale * length), 1) for length in size_m)
    right = ((np.arange(width * FINER) + 0.5) / (width * FINER) - 0.5) * size_m[0]
    up = (0.5 - (np.arange(height * FINER) + 0.5) / (height * FINER)) * size_m[1]
    picture = np.empty((height * FINER, width * FINER, 3))
    picture[:] = ground
    for mark in marks:
        x, y = np.meshgrid(right - mark.at_m[0], up - mark.at_m[1])
        turn = np.radians(mark.turned_deg)
        along, across = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        picture[_covered(mark, along / mark.size_m, across / mark.size_m)] = mark.colour
    return np.asarray(picture.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3)))


def _covered(mark: Mark, x: Floats, y: Floats) -> Mask:
    """Return which points a mark covers; x to the right and y up from its middle, in parts of its size."""
    return _text(mark.text, x, y) if mark.text is not None else MASKS[mark.shape](x, y)


def _text(text: str, x: Floats, y: Floats) -> Mask:
    row = np.floor((0.5 - y) * 7.0).astype(int)
    column = np.floor(x * 7.0 + 0.5 * (6 * len(text) - 1)).astype(int)
    points = np.zeros((7, 6 * len(text)), bool)
    for number, letter in enumerate(text):
        for line, bits in enumerate(LETTERS.get(letter, bytes(7))):
            points[line, 6 * number : 6 * number + 5] = [bits >> (4 - k) & 1 for k in range(5)]
    inside = (row >= 0) & (row < 7) & (column >= 0) & (column < points.shape[1])
    return np.asarray(inside & points[row.clip(0, 6), column.clip(0, points.shape[1] - 1)])


def _square(x: Floats, y: Floats, width: float = 1.0, height: float = 1.0) -> Mask:
    return np.asarray((np.abs(x) <= 0.5 * width) & (np.abs(y) <= 0.5 * height))


def _triangle(x: Floats, y: Floats) -> Mask:
    """An equilateral triangle that points up; its middle is that of its height."""
    return np.asarray((np.abs(y) <= 0.25 * 3**0.5) & (np.abs(x) <= (0.25 * 3**0.5 - y) / 3**0.5))


def _star(x: Floats, y: Floats) -> Mask:
    """A star with five points, as one draws it by a single line."""
    sector = np.mod(np.arctan2(x, y), 2 * np.pi / 5)
    angle = np.minimum(sector, 2 * np.pi / 5 - sector)
    return np.asarray(np.hypot(x, y) * np.cos(2 * np.pi / 5 - angle) <= 0.5 * np.cos(2 * np.pi / 5))


def _arrow(x: Floats, y: Floats) -> Mask:
    head = (y >= 0.1) & (y <= 0.5) & (np.abs(x) <= 0.75 * (0.5 - y))
    return np.asarray(head | ((np.abs(x) <= 0.1) & (y >= -0.5) & (y < 0.1)))


def _fish(x: Floats, y: Floats) -> Mask:
    """A fish that swims to the left: a body, a tail and an eye."""
    body = ((x + 0.1) / 0.4) ** 2 + (y / 0.2) ** 2 <= 1.0
    tail = (x >= 0.2) & (x <= 0.5) & (np.abs(y) <= 0.6 * (x - 0.2) + 0.04)
    return np.asarray((body | tail) & (np.hypot(x + 0.32, y - 0.04) > 0.03))


MASKS: dict[str, Callable[[Floats, Floats], Mask]] = {
    "disc": lambda x, y: np.asarray(np.hypot(x, y) <= 0.5),
    "ring": lambda x, y: np.asarray(np.abs(np.hypot(x, y) - 0.4) <= 0.1),
    "square": _square,
    "triangle": _triangle,
    "cross": lambda x, y: _square(x, y, height=1 / 3) | _square(x, y, width=1 / 3),
    "star": _star,
    "arrow": _arrow,
    "stripes": lambda x, y: _square(x, y) & (np.mod(np.floor(5.0 * (x + 0.5)), 2) == 0),
    "fish": _fish,
}
