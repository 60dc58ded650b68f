"""Scan graphs, OctoMap's own files of scans (.graph): clouds, each in the frame of its sensor's pose.

Source: OctoMap 1.9.7, ScanGraph::writeBinary, Pose6D and Quaternion: little-endian counts and float64, of which OctoMap
keeps float32. Its arithmetic is repeated here step by step, so that points fall into the same voxels.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.texts.text_file import read_limited

BYTES_MAX = 2_000_000_000
POINT = np.dtype([("count", "<u4"), ("xyz", "<f8", 3)])
POSE = np.dtype([("three", "<u4"), ("position", "<f8", 3), ("four", "<u4"), ("uxyz", "<f8", 4), ("id", "<u4")])
EDGE_BYTES = 4 + 4 + POSE.itemsize - 4 + 8


class Scan(NamedTuple):
    """A scan. points_world_m: (n, 3) float32. origin_m: (3,) float64, its sensor's position."""

    points_world_m: NDArray[np.float32]
    origin_m: NDArray[np.float64]


def read_scans(path: Path) -> Iterator[Scan]:
    """Yield the scans of a graph, in its order. Raises ValueError."""
    data = read_limited(path, f"'{path}'", BYTES_MAX)
    at, left = 4, int.from_bytes(data[:4], "little")
    if len(data) < 4 or left * (4 + POSE.itemsize) > len(data):
        raise ValueError(f"'{path}': must begin with the number of its scans")
    while left:
        count = int.from_bytes(data[at : at + 4], "little")
        end = at + 4 + count * POINT.itemsize
        if end + POSE.itemsize > len(data):
            raise ValueError(f"'{path}': byte {at}: is cut short, {left} scans before its end")
        points = np.frombuffer(data, POINT, count, at + 4)
        (pose,) = np.frombuffer(data, POSE, 1, end)
        if (points["count"] != 3).any() or pose["three"] != 3 or pose["four"] != 4:
            raise ValueError(f"'{path}': byte {at}: must be a scan of points with three numbers each, and its pose")
        numbers = np.concatenate([points["xyz"].ravel(), pose["position"], pose["uxyz"]])
        if not (np.abs(numbers) < np.finfo(np.float32).max).all():
            raise ValueError(f"'{path}': byte {at}: has numbers that are not finite")
        position = pose["position"].astype(np.float32)
        yield Scan(_placed(points["xyz"].astype(np.float32), pose["uxyz"].astype(np.float32), position),
                   position.astype(np.float64))  # fmt: skip
        at, left = end + POSE.itemsize, left - 1
    edges = int.from_bytes(data[at : at + 4], "little")  # between scans, which a map does not need
    if len(data) != at + 4 + edges * EDGE_BYTES:
        raise ValueError(f"'{path}': byte {at}: must end with its {edges} edges")


def _placed(
    points: NDArray[np.float32], turn: NDArray[np.float32], position: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return points (n, 3) in the world: turned by a quaternion u, x, y, z as q v q*, then moved, all in float32."""
    zero = np.zeros(len(points), np.float32)
    inverse = turn * np.array([1, -1, -1, -1], np.float32)
    _, *turned = _product(_product(tuple(turn), (zero, *points.T)), tuple(inverse))
    return np.ascontiguousarray(np.column_stack(turned) + position)


def _product(a: tuple[NDArray[np.float32], ...], b: tuple[NDArray[np.float32], ...]) -> tuple[NDArray[np.float32], ...]:
    (au, ax, ay, az), (bu, bx, by, bz) = a, b
    return (
        au * bu - ax * bx - ay * by - az * bz,
        ay * bz - by * az + au * bx + ax * bu,
        az * bx - bz * ax + au * by + ay * bu,
        ax * by - bx * ay + au * bz + az * bu,
    )
