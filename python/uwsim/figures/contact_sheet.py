"""Contact sheet: pictures of the same size laid out in rows, with thin gaps; `uwsim scenario camera` writes one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
GAP = 4  # pixels between pictures


def contact_sheet(rows: Sequence[Sequence[Image]]) -> Image:
    """Return rows of pictures, each (H, W, 3) uint8, as a single picture on a white background."""
    height, width, _ = rows[0][0].shape
    columns = max(len(row) for row in rows)
    sheet = np.full((len(rows) * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3), 255, np.uint8)
    for j, row in enumerate(rows):
        for i, image in enumerate(row):
            y, x = j * (height + GAP), i * (width + GAP)
            sheet[y : y + height, x : x + width] = image
    return sheet
