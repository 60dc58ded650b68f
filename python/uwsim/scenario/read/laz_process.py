"""Decompression of a LAZ file by lazrs: the script of a contained process; to start quickly, it imports no uwsim."""

from __future__ import annotations

from typing import Any

import laspy
import numpy as np


def read(path: str) -> dict[str, Any]:
    """Return the points (n, 3) of a LAS or LAZ file, whatever its version, chunks or octree (COPC)."""
    las = laspy.read(path, laz_backend=laspy.LazBackend.Lazrs)
    return {"points": np.stack([np.asarray(axis, np.float64) for axis in (las.x, las.y, las.z)], axis=1)}
