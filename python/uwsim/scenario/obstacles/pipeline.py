"""The obstacle `pipeline`, a tube that follows the bed."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from uwsim import _core
from uwsim.scenario.build.pipeline import (
    DEBRIS,
    PipeRun,
    Rings,
    all_features,
    pipe_debris,
    pipe_leaks,
    pipe_parts,
    pipe_rings,
    triangle_albedos,
)
from uwsim.scenario.build.solids import SIDES, Mesh, bed_below
from uwsim.scenario.read.mesh_file import joined
from uwsim.scenario.read.textures import Texture, palette_texture
from uwsim.scenario.spec.fields import InRange, Name, Point2, broken
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import Bed, BubblePlume, OnBed, Part, PipeCondition, Solid

MAX_BEND_DEG = 120.0


class Pipeline(OnBed):
    """A pipe that follows the terrain below a line through points_m (x, y).

    points_m: corners of the line, x and y. radius_m: outer radius. buried_fraction: fraction of the diameter below the
    bed. condition: its joints and anodes, damage, spans, burial, debris and leaks; without it, the pipe is smooth.
    """

    surface_class: ClassVar = "pipeline"

    kind: Literal["pipeline"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="concrete")
    points_m: Annotated[tuple[Point2, ...], Field(min_length=2, max_length=1000)]
    radius_m: Annotated[float, InRange(0.02, 10, "m")] = Field(examples=[0.3])
    buried_fraction: Annotated[float, InRange(0, 0.95)] = 0.2
    condition: PipeCondition | None = None

    @model_validator(mode="after")
    def _bends_gently(self) -> Pipeline:
        headings = []
        for (x0, y0), (x1, y1) in pairwise(self.points_m):
            if math.hypot(x1 - x0, y1 - y0) < 1e-3:
                raise broken(f"the point ({x1:g}, {y1:g}) m occurs twice in a row", at=("points_m",))
            headings.append(math.atan2(y1 - y0, x1 - x0))
        for before, after in pairwise(headings):
            bend_deg = abs(math.degrees(math.remainder(after - before, 2 * math.pi)))
            if bend_deg > MAX_BEND_DEG:
                rule = f"the pipe bends by {bend_deg:.0f} deg: must be at most {MAX_BEND_DEG:.0f} deg"
                raise broken(rule, at=("points_m",))
        if self.condition is not None:
            try:
                all_features(self.condition, self._length_m)
            except ValueError as error:
                raise broken(str(error), at=("condition",)) from None
        return self

    def solid(self, terrain: Bed) -> Solid:
        """Return a tube along the line, whose axis is radius (1 - 2 buried_fraction) above the bed at each point."""
        xy = _densified(np.asarray(self.points_m, np.float64), step_m=max(1.0, terrain.spacing_m))
        lift = self.radius_m * (1 - 2 * self.buried_fraction)
        if self.condition is not None:
            made = self._rings(self.condition)
            course = self._course(made, terrain)
            pipe = swept_tube(course.axis_m, made.radius_m)
            vertices, triangles = joined([pipe, *pipe_debris(self.condition, course, self._length_m)])
            return Solid(vertices, triangles.astype(np.uint32), [])
        axis = np.column_stack([xy, bed_below(terrain, xy, self.name) + lift])
        shapes = _core.RoundShape.pipe(axis, self.radius_m)
        return Solid(*swept_tube(axis, self.radius_m), shapes)

    def texture(self) -> Texture | None:
        """Return the colours of coating, joints, anodes and rust, unless the material has its own."""
        if self.condition is None or self.material.colour is not None:
            return None
        made = self._rings(self.condition)
        level = PipeRun(made.along_m, np.column_stack([made.along_m, np.zeros((len(made.along_m), 2))]), self.radius_m)
        lying = sum(len(triangles) for _, triangles in pipe_debris(self.condition, level, self._length_m))
        return palette_texture(np.vstack([triangle_albedos(made.albedo), np.tile(DEBRIS, (lying, 1))]))

    def parts(self, terrain: Bed) -> list[Part]:
        """See ObstacleModel."""
        if self.condition is None:
            return []
        return pipe_parts(self.condition, self._course(self._rings(self.condition), terrain), self._length_m)

    @property
    def leaks(self) -> int:
        """See ObstacleModel."""
        if self.condition is None:
            return 0
        return sum(one.kind == "leak" for one in all_features(self.condition, self._length_m))

    def plumes(self, terrain: Bed) -> list[BubblePlume]:
        """See ObstacleModel."""
        if self.condition is None:
            return []
        return pipe_leaks(self.condition, self._course(self._rings(self.condition), terrain), self._length_m)

    @property
    def _length_m(self) -> float:
        return float(self._corners_m()[-1])

    def _corners_m(self) -> NDArray[np.float64]:
        """Return the distances of the corners along the line (k,)."""
        steps = np.linalg.norm(np.diff(np.asarray(self.points_m, np.float64), axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def _rings(self, condition: PipeCondition) -> Rings:
        buried_m = 2 * self.radius_m * self.buried_fraction
        return pipe_rings(condition, self._length_m, self._corners_m(), self.radius_m, buried_m)

    def _course(self, made: Rings, terrain: Bed) -> PipeRun:
        """Return where it lies: straight between corners on the chart, and as high above the bed as the rings are."""
        corners, points = self._corners_m(), np.asarray(self.points_m, np.float64)
        xy = np.column_stack([np.interp(made.along_m, corners, points[:, k]) for k in range(2)])
        lies_m = self.radius_m * (1 - 2 * self.buried_fraction)
        axis_m = np.column_stack([xy, bed_below(terrain, xy, self.name) + lies_m + made.lift_m])
        return PipeRun(made.along_m, axis_m, self.radius_m)


def _densified(points: NDArray[np.float64], step_m: float) -> NDArray[np.float64]:
    """Return the polyline (n, k) with points added so that consecutive ones are at most step_m apart."""
    pieces = []
    for start, end in pairwise(points):
        count = int(np.ceil(np.linalg.norm(end - start) / step_m))
        pieces.append(start + (end - start) * np.arange(count)[:, None] / count)
    return np.concatenate([*pieces, points[-1:]])


def swept_tube(axis_m: NDArray[np.float64], radius_m: float | NDArray[np.float64]) -> Mesh:
    """Return a closed tube with SIDES sides and mitred bends along a line (n, 3) that does not start vertically.

    radius_m: of all, or (n, SIDES), at each point and side.
    """
    directions = np.diff(axis_m, axis=0)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    before, after = np.vstack([directions[:1], directions]), np.vstack([directions, directions[-1:]])
    side, up = _untwisted_frames(before)
    angles = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    radius = np.asarray(radius_m)[..., None] if np.ndim(radius_m) else radius_m
    rings = radius * (np.cos(angles)[None, :, None] * side[:, None] + np.sin(angles)[None, :, None] * up[:, None])
    # Each ring slides along the preceding straight piece into the plane that bisects the bend.
    mitres = before + after
    slide = np.einsum("nak,nk->na", rings, mitres) / np.einsum("nk,nk->n", before, mitres)[:, None]
    rings += axis_m[:, None] - slide[..., None] * before[:, None]
    return _skinned(rings, axis_m[0], axis_m[-1])


def _untwisted_frames(directions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two unit normals for each of (n, 3) unit directions, with the smallest rotation between neighbours.

    This keeps the tube's edges straight through a bend; with independent frames, a tube that also climbs would be
    twisted.
    """
    side = np.empty_like(directions)
    side[0] = np.cross([0.0, 0.0, 1.0], directions[0])
    side[0] /= np.linalg.norm(side[0])
    for k, (a, b) in enumerate(pairwise(directions)):
        v = side[k]
        side[k + 1] = v + 2 * b * (a @ v) - (a + b) * ((a + b) @ v) / (1 + a @ b)
    return side, np.cross(directions, side)


def _skinned(rings: NDArray[np.float64], first: NDArray[np.float64], last: NDArray[np.float64]) -> Mesh:
    """Return a mesh over rings (n, sides, 3), counter-clockwise seen from the tube's end, with a fan at each end."""
    n, sides, _ = rings.shape
    a = np.arange((n - 1) * sides).reshape(n - 1, sides)
    b = np.roll(a, -1, axis=1)
    wall = np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1).reshape(-1, 3)
    ring, after = np.arange(sides), np.roll(np.arange(sides), -1)
    start, end = n * sides, n * sides + 1
    start_fan = np.column_stack([np.full(sides, start), after, ring])
    end_fan = np.column_stack([np.full(sides, end), ring + (n - 1) * sides, after + (n - 1) * sides])
    vertices = np.vstack([rings.reshape(-1, 3), first, last])
    return vertices, np.vstack([wall, start_fan, end_fan]).astype(np.uint32)
