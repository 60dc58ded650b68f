"""Obstacles of lines: single lines, and nets with their frames."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictBool, model_validator

from uwsim.base.arrays import Floats
from uwsim.scenario.build.cover_meshes import tube
from uwsim.scenario.build.solids import bars, posed
from uwsim.scenario.obstacles.gates import torus
from uwsim.scenario.read.mesh_file import joined
from uwsim.scenario.spec.fields import InRange, Name, Point3, Size, YawPitchRoll, broken
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Part, Placed, Solid

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


MAX_KNOTS = 100_000
COLLAR_M, SINKER_M = 0.2, 0.08
"""Radii of the floating collar and of the sinker ring at the foot of the wall."""


class Net(Placed):
    """A net pen: a collar, a round wall with vertical and horizontal strands, a sinker ring, and a conical bottom.

    position_m: the middle of the collar (world), unless it is on_bed. radius_m, depth_m: radius and height of the wall.
    cone_m: depth of the bottom's middle below the wall. mesh_m: distance between strands, along the bars. strand_m:
    their diameter. holes: number of holes in the wall. hole_m: their diameter. seed: of the holes' places.
    """

    kind: Literal["net"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint", colour=(0.06, 0.08, 0.06))
    radius_m: Size
    depth_m: Size
    cone_m: Annotated[float, InRange(0, 1000, "m")] = 2.0
    mesh_m: Annotated[float, InRange(0.01, 10, "m")] = 0.2
    strand_m: Annotated[float, InRange(0.001, 1, "m")] = 0.012
    holes: Annotated[int, InRange(0, 100)] = 0
    hole_m: Annotated[float, InRange(0.05, 20, "m")] = 0.8
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    @model_validator(mode="after")
    def _fits(self) -> Net:
        around, rows, rings = self._counts()
        if (knots := around * (rows + rings)) > MAX_KNOTS:
            raise broken(f"wall and bottom have {knots} knots: must be at most {MAX_KNOTS}; make mesh_m larger")
        if self.strand_m >= 0.5 * self.mesh_m:
            raise broken("must be below half of mesh_m", at=("strand_m",), value=self.strand_m, unit="m")
        if self.holes and 2 * self.hole_m >= self.depth_m:
            raise broken("must be below half of depth_m", at=("hole_m",), value=self.hole_m, unit="m")
        self.holes_m()
        return self

    def holes_m(self) -> Floats:
        """Return the middles of the holes (n, 3), at least two diameters apart."""
        random = np.random.default_rng([self.seed, 0x6E6574])
        found: list[Floats] = []
        for _ in range(50 * self.holes):
            if len(found) == self.holes:
                break
            turn, z = random.uniform(0, 2 * np.pi), -random.uniform(self.hole_m, self.depth_m - self.hole_m)
            at = np.array([self.radius_m * np.cos(turn), self.radius_m * np.sin(turn), z])
            if all(np.linalg.norm(at - other) > 2 * self.hole_m for other in found):
                found.append(at)
        if len(found) < self.holes:
            raise broken("too many holes for this wall", at=("holes",), value=self.holes)
        return np.array(found).reshape(-1, 3) + self.position_m

    def parts(self, terrain: Bed) -> list[Part]:
        """See ObstacleModel."""
        return [Part("hole", place_m) for place_m in self.holes_m()]

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        around, rows, rings = self._counts()
        turn = 2 * np.pi * np.arange(around) / around
        circle = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
        levels = -self.depth_m * np.arange(rows) / (rows - 1)
        wall = self.radius_m * circle[None] + levels[:, None, None] * [0, 0, 1]
        inward = np.linspace(1.0, 0.06, rings)[:, None, None]
        cone = self.radius_m * circle[None] * inward - (self.depth_m + self.cone_m * (1 - inward)) * [0, 0, 1]
        starts, ends = [], []
        for sheet in (wall, cone):
            starts += [sheet.reshape(-1, 3), sheet[:-1].reshape(-1, 3)]
            ends += [np.roll(sheet, -1, axis=1).reshape(-1, 3), sheet[1:].reshape(-1, 3)]
        start, end = np.concatenate(starts), np.concatenate(ends)
        middle = 0.5 * (start + end)
        whole = np.ones(len(middle), np.bool_)
        for hole in self.holes_m() - self.position_m:
            whole &= np.linalg.norm(middle - hole, axis=1) > 0.5 * self.hole_m
        parts = [_strands(start[whole], end[whole], 0.5 * self.strand_m)]
        for radius_m, z in ((COLLAR_M, 0.0), (SINKER_M, -self.depth_m)):
            vertices, triangles = torus(self.radius_m, radius_m)
            parts.append((posed(vertices, (0.0, 0.0, z), (0.0, 90.0, 0.0)), triangles))
        vertices, triangles = joined(parts)
        return Solid(posed(vertices, self.position_m, LEVEL), triangles.astype(np.uint32), [])

    def _counts(self) -> tuple[int, int, int]:
        """Return the number of vertical strands, of rows of knots in the wall, and of those in the bottom."""
        around = max(round(2 * np.pi * self.radius_m / self.mesh_m), 8)
        return around, max(round(self.depth_m / self.mesh_m), 1) + 1, max(round(self.radius_m / self.mesh_m / 2), 2)


def _strands(start: Floats, end: Floats, radius_m: float) -> tuple[Floats, NDArray[np.uint32]]:
    """Return closed three-sided prisms between points (n, 3)."""
    along = end - start
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.cross(along, np.where(np.abs(along[:, 2:]) > 0.9, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]]))
    side /= np.linalg.norm(side, axis=1)[:, None]
    other = np.cross(along, side)
    corners = [np.cos(a) * side + np.sin(a) * other for a in 2 * np.pi * np.arange(3) / 3]
    vertices = np.stack([at + radius_m * corner for at in (start, end) for corner in corners], axis=1)
    prism = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    first = 6 * np.arange(len(start))[:, None, None]
    return vertices.reshape(-1, 3), (first + np.array(prism)).reshape(-1, 3).astype(np.uint32)
