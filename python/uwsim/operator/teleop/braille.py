"""A canvas of dots in a terminal. Each character is a braille pattern of 2 x 4 dots (Unicode block U+2800)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

COLUMNS, ROWS = 2, 4
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
EMPTY = 0x2800


class Canvas:
    """A canvas whose dots are addressed from the top left. A character takes the style of its highest-ranking dots."""

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = width, height
        self._cells = np.zeros((height, width), int)
        self._ranks = np.zeros((height, width), int)
        self._styles = [""]

    def dot(self, across: NDArray[np.float64], down: NDArray[np.float64], style: str) -> None:
        """Set dots. Dots outside the canvas are ignored. Dots that are set later have a higher rank."""
        self._styles.append(style)
        column, row = np.rint(across).astype(int), np.rint(down).astype(int)
        inside = (column >= 0) & (column < COLUMNS * self.width) & (row >= 0) & (row < ROWS * self.height)
        column, row = column[inside], row[inside]
        at = (row // ROWS, column // COLUMNS)
        np.bitwise_or.at(self._cells, at, _BITS[row % ROWS, column % COLUMNS])
        self._ranks[at] = len(self._styles) - 1

    def text(self) -> Text:
        """Return the picture."""
        picture = Text(no_wrap=True)
        for cells, ranks in zip(self._cells, self._ranks, strict=True):
            for cell, rank in zip(cells, ranks, strict=True):
                picture.append(chr(EMPTY + int(cell)) if cell else " ", self._styles[rank])
            picture.append("\n")
        picture.right_crop()
        return picture
