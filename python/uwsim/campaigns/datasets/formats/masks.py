"""Run-length encoding of masks as defined by COCO: column by column, starting with pixels outside the mask.

Run lengths are written as plain lists ("uncompressed RLE"), which pycocotools, torchvision and Detectron2 all read;
torchvision cannot read the compressed form.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def run_lengths(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return a mask (H, W) as a COCO `segmentation`."""
    flat = mask.ravel(order="F")
    edges = np.flatnonzero(np.diff(flat)) + 1
    ends = np.concatenate([[0], edges, [flat.size]])
    counts = np.diff(ends).tolist()
    return {"size": list(mask.shape), "counts": [0, *counts] if flat.size and flat[0] else counts}


def bounds(mask: NDArray[np.bool_]) -> list[int]:
    """Return x, y, width, height [pixels] of the bounding box of a non-empty mask (H, W)."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1]
