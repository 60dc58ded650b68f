"""Conversion of arrays to Foxglove scene entities: meshes, lines and cubes."""

from __future__ import annotations

import numpy as np
from foxglove.messages import (
    Color,
    CubePrimitive,
    LinePrimitive,
    LinePrimitiveLineType,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)
from numpy.typing import ArrayLike, NDArray

DEEP, SHALLOW = np.array([0.16, 0.22, 0.32, 1.0]), np.array([0.76, 0.66, 0.46, 1.0])


def timestamp(time_ns: int) -> Timestamp:
    """Return a Timestamp."""
    return Timestamp(*divmod(time_ns, 1_000_000_000))


def points(positions_m: ArrayLike) -> list[Point3]:
    """Return points from an array (n, 3)."""
    return [Point3(x=x, y=y, z=z) for x, y, z in np.asarray(positions_m, float).tolist()]


def by_height(heights_m: NDArray[np.floating], bands_m: float | None = None) -> list[Color]:
    """Return colours between DEEP and SHALLOW for heights (n,). bands_m: the interval at which colours repeat."""
    if bands_m is None:
        low, high = float(heights_m.min()), float(heights_m.max())
        share = (heights_m - low) / max(high - low, 1e-9)
    else:
        share = np.abs(2.0 * (heights_m / bands_m % 1.0) - 1.0)
    return [Color(r=r, g=g, b=b, a=a) for r, g, b, a in (DEEP + share[:, None] * (SHALLOW - DEEP)).tolist()]


def mesh(
    name: str,
    frame_id: str,
    vertices_m: NDArray[np.floating],
    triangles: NDArray[np.integer],
    color: Color | None = None,
    *,
    frame_locked: bool = False,
    pose: Pose | None = None,
    time_ns: int | None = None,
) -> SceneEntity:
    """Return a surface from vertices (n, 3) and triangles (m, 3), coloured by height unless a colour is given.

    pose: of the surface's own axes in the frame.
    """
    shade = {"colors": by_height(np.asarray(vertices_m)[:, 2])} if color is None else {"color": color}
    corners, indices = points(vertices_m), np.asarray(triangles).ravel().tolist()
    surface = TriangleListPrimitive(pose=pose, points=corners, indices=indices, **shade)
    stamp = None if time_ns is None else timestamp(time_ns)
    return SceneEntity(timestamp=stamp, id=name, frame_id=frame_id, frame_locked=frame_locked, triangles=[surface])


def line(
    name: str, frame_id: str, positions_m: ArrayLike, color: Color, thickness_px: float, time_ns: int
) -> SceneEntity:
    """Return a line through positions (n, 3), with a thickness in screen pixels."""
    strip = LinePrimitive(
        type=LinePrimitiveLineType.LineStrip,
        points=points(positions_m),
        color=color,
        thickness=thickness_px,
        scale_invariant=True,
    )
    return SceneEntity(timestamp=timestamp(time_ns), id=name, frame_id=frame_id, lines=[strip])


def cubes(
    name: str, frame_id: str, centres_m: NDArray[np.floating], colors: list[Color], edge_m: float, time_ns: int
) -> SceneEntity:
    """Return cubes at centres (n, 3)."""
    size, level = Vector3(x=edge_m, y=edge_m, z=edge_m), Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
    found = [
        CubePrimitive(pose=Pose(position=Vector3(x=x, y=y, z=z), orientation=level), size=size, color=color)
        for (x, y, z), color in zip(centres_m.tolist(), colors, strict=True)
    ]
    return SceneEntity(timestamp=timestamp(time_ns), id=name, frame_id=frame_id, cubes=found)
