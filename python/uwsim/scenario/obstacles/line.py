"""The obstacle `line`: bars, ropes, cables and chains between points, such as ladders, frames and moorings."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictBool, model_validator

from uwsim.base.arrays import Floats
from uwsim.scenario.build.cover_meshes import tube
from uwsim.scenario.build.solids import bars, posed
from uwsim.scenario.read.mesh_file import joined
from uwsim.scenario.spec.fields import InRange, Name, Point3, YawPitchRoll, broken
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid

SAG_PIECES = 16
PITCH = 5.0
"""Distance between the middles of a chain's links in radii of its bar: inside, a link is 5 radii long and 2 wide."""
MAX_LINKS, MAX_BARS = 5000, 100_000
Polyline = Annotated[tuple[Point3, ...], Field(min_length=2, max_length=200)]


class Line(Placed):
    """Round bars, ropes or chains along polylines.

    position_m: the origin of the points (world), unless it is on_bed. lines_m: polylines, each a list of points.
    radius_m: radius of the bar or rope, or of the bar that a chain's links are made of. sag_m: how far the middle of
    each piece hangs below its chord, as a parabola. links: whether it is a chain.
    """

    kind: Literal["line"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    lines_m: tuple[Polyline, ...] = Field(min_length=1, max_length=500, examples=[[[[0, 0, 0], [0, 0, 2]]]])
    radius_m: Annotated[float, InRange(0.002, 10, "m")] = Field(examples=[0.05])
    sag_m: Annotated[float, InRange(0, 1000, "m")] = 0.0
    links: StrictBool = False

    @model_validator(mode="after")
    def _has_lengths(self) -> Line:
        pieces = [np.subtract(b, a) for line in self.lines_m for a, b in pairwise(line)]
        lengths = [float(np.linalg.norm(piece)) for piece in pieces]
        if min(lengths) < 1e-3:
            raise broken("a point occurs twice in a row", at=("lines_m",))
        hung_m = sum(length + 2 * self.sag_m for length in lengths)  # at least the length of the parabolas
        if self.links and hung_m > MAX_LINKS * PITCH * self.radius_m:
            raise broken(f"a chain must have at most {MAX_LINKS} links", at=("lines_m",))
        if (SAG_PIECES if self.sag_m else 1) * len(lengths) > MAX_BARS:
            raise broken(f"must have at most {MAX_BARS} bars, or {MAX_BARS // SAG_PIECES} that sag", at=("lines_m",))
        return self

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        pieces = [
            posed(_hanging(np.array(a), np.array(b), self.sag_m), self.position_m, self.yaw_pitch_roll_deg)
            for line in self.lines_m
            for a, b in pairwise(line)
        ]
        if not self.links:
            return bars([ends for piece in pieces for ends in pairwise(piece)], self.radius_m)
        vertices, triangles = joined([link for piece in pieces for link in _chain(piece, self.radius_m)])
        return Solid(vertices, triangles.astype(np.uint32), [])


def _hanging(start: Floats, end: Floats, sag_m: float) -> Floats:
    """Return points (n, 3) from start to end, straight or along a parabola."""
    if sag_m == 0.0:
        return np.stack([start, end])
    t = np.linspace(0, 1, SAG_PIECES + 1)[:, None]
    return start + t * (end - start) - 4 * sag_m * t * (1 - t) * [0, 0, 1]


def _chain(points: Floats, radius_m: float) -> list[tuple[Floats, NDArray[np.uint32]]]:
    """Return links along points (n, 3), each turned by a quarter about the chain from the one before."""
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    middles = np.arange(0.5 * PITCH * radius_m, run[-1], PITCH * radius_m)
    at, after = (np.stack([np.interp(middles + by, run, axis) for axis in points.T], 1) for by in (0.0, 0.1 * radius_m))
    before = np.stack([np.interp(middles - 0.1 * radius_m, run, axis) for axis in points.T], 1)
    links, triangles = [], _LINK[1]
    for k, (middle, along) in enumerate(zip(at, after - before, strict=True)):
        x = along / np.linalg.norm(along)
        y = np.cross([0.31, 0.05, 0.95] if abs(x[2]) < 0.9 else [0.95, 0.31, 0.05], x)
        y /= np.linalg.norm(y)
        z = np.cross(x, y)
        frame = np.stack([x, *((y, z) if k % 2 else (z, -y))])
        links.append((middle + radius_m * _LINK[0] @ frame, triangles))
    return links


def _link() -> tuple[Floats, NDArray[np.uint32]]:
    """Return a link along x of a bar of radius 1: two half circles, and straight sides between them."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, 5)
    half = np.stack([1.5 + 2.0 * np.cos(turn), 2.0 * np.sin(turn), 0 * turn], axis=1)
    loop = np.vstack([half, half * [-1, -1, 1]])
    vertices, triangles = tube(np.vstack([loop, loop[:1]]), np.ones(11), 6, closed=False)
    triangles = np.where(triangles >= 60, triangles - 60, triangles)
    return vertices[:60], triangles.astype(np.uint32)


_LINK = _link()
