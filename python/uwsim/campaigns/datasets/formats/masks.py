"""Run lengths of masks, as COCO defines them: column by column, beginning with pixels outside the mask.

They are written as plain lists ("uncompressed RLE"), which pycocotools, torchvision and Detectron2 all read;
torchvision does not read the compressed text.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def run_lengths(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return the `segmentation` of a mask (H, W)."""
    flat = mask.ravel(order="F")
    edges = np.flatnonzero(np.diff(flat)) + 1
    ends = np.concatenate([[0], edges, [flat.size]])
    counts = np.diff(ends).tolist()
    return {"size": list(mask.shape), "counts": [0, *counts] if flat.size and flat[0] else counts}


def bounds(mask: NDArray[np.bool_]) -> list[int]:
    """Return x, y, width, height [pixels] of the smallest box round a mask (H, W), which must not be empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1]
