"""The plan of an edited scenario: its bed, the solids of its obstacles and props, and the obstacles' outlines."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.quaternions import of_yaw_pitch_roll_deg, product, turned
from uwsim.channels.guest import Values
from uwsim.operator.station.scene.scene import described_grid, glb, own_colours, plan_outline, thinned
from uwsim.scenario import Scenario
from uwsim.scenario.build.arm import link_mesh
from uwsim.scenario.build.camera import obstacle_texture
from uwsim.scenario.build.loose_bodies import object_start, own_turn
from uwsim.scenario.build.solids import bed_below, grounded, obstacle_solid
from uwsim.scenario.build.terrain import Terrain, build_terrain
from uwsim.scenario.read.mesh_file import Triangles, Vertices, joined
from uwsim.scenario.spec.arm import links_in_order
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.obstacle import ObstacleModel, Placed
from uwsim.scenario.spec.prop import PropEntry
from uwsim.scenario.spec.terrain import TerrainSpec

Floats = NDArray[np.float64]
UNPAINTED = (0.485, 0.552, 0.604)
"""The albedo shown of a material whose kind has no single one."""


class Surface(NamedTuple):
    """A surface in the world, and the shape whose colours it has."""

    vertices: Vertices
    triangles: Triangles
    shape: ObstacleModel


class GroundPlan:
    """The bed and the parts with a solid, obstacles and then props, of which only what has changed is made again.

    outlines_m: of the obstacles. edition: increases with each change of such a part, bed_edition with each of the bed.
    """

    def __init__(self) -> None:
        self.outlines_m: list[list[list[float]]] = []
        self.edition = self.bed_edition = 0
        self._surfaces: list[list[Surface]] = []
        self._parts: tuple[ObstacleModel | PropEntry, ...] = ()
        self._scenario: Scenario | None = None
        self._spec: TerrainSpec | None = None
        self._terrain: Terrain | None = None

    def draw(self, scenario: Scenario) -> None:
        """Make the plan of a scenario. Raises ScenarioError, changing nothing, if a part cannot be built."""
        is_same = scenario.terrain == self._spec and self._terrain is not None
        terrain = self._terrain if is_same else build_terrain(scenario.terrain)
        assert terrain is not None
        props = scenario.placed_props
        own = scenario.obstacles[: len(scenario.obstacles) - sum(len(prop.model.obstacles) for prop in props)]
        known = list(zip(self._parts, self._surfaces, strict=True)) if is_same else []
        parts: tuple[ObstacleModel | PropEntry, ...] = (*own, *props)
        made: list[list[Surface]] = []
        for k, part in enumerate(parts):
            place = ("obstacles", k) if k < len(own) else ("props", k - len(own))
            same = next((surfaces for each, surfaces in known if each == part), None)
            with scenario.source_file.errors_at(*place):
                made.append(list(_surfaces(part, terrain)) if same is None else same)
        outlines = [
            plan_outline(part, partial(np.asarray, surfaces[0].vertices), np.zeros(2))
            for part, surfaces in zip(own, made, strict=False)
        ]
        self.edition += parts != self._parts or not is_same
        self.bed_edition += not is_same
        self._scenario, self._spec, self._terrain = scenario, scenario.terrain, terrain
        self._parts, self.outlines_m, self._surfaces = parts, outlines, made

    def bed_at_m(self, x: float, y: float, name: str) -> float:
        """Return the z of the bed at the place of a part. Raises ScenarioError beside the terrain."""
        assert self._terrain is not None
        return round(float(bed_below(self._terrain, np.array([[x, y]]), name)[0]), 3)

    def stands_at_m(self, prop: PropEntry) -> float:
        """Return the z at which a prop stands on the bed: its origin or its surface touches it, and none is below.

        Raises ScenarioError for a prop that reaches beyond the terrain.
        """
        assert self._terrain is not None
        points = np.concatenate(
            [[prop.position_m], *(each.vertices for each in _surfaces(prop, self._terrain))], dtype=np.float64
        )
        below_m = bed_below(self._terrain, points[:, :2], prop.name) - points[:, 2]
        return math.ceil(1e3 * (prop.position_m[2] + float(below_m.max())) - 1e-6) / 1e3

    def solid(self, edition: int, number: int) -> bytes:
        """Return a part as binary glTF, b"" if a newer edition replaces it. Raises ValueError if it never was."""
        if 0 <= edition < self.edition:
            return b""
        if edition != self.edition or number >= len(self._surfaces) or self._scenario is None:
            raise ValueError(f"part {number} of edition {edition}: does not exist")
        surfaces = self._surfaces[number]
        colours = []
        for _, triangles, shape in surfaces:
            own = own_colours(obstacle_texture(shape, self._scenario), len(triangles))
            usual = np.tile(shape.surface.colour or UNPAINTED, (len(triangles), 1))
            colours.append(usual if own is None else own)
        mesh = joined([(each.vertices, each.triangles) for each in surfaces])
        return glb(mesh, np.zeros(3), np.concatenate(colours))

    @property
    def grid(self) -> Values:
        """The grid of the bed's heights; see wire.editor.BedGrid."""
        grid = self._thinned()
        return {**described_grid(grid.heights_m, grid.origin_m, grid.spacing_m), "edition": self.bed_edition}

    def heights(self) -> bytes:
        """Return the heights of the grid's points as float32, the southernmost row first."""
        return np.asarray(self._thinned().heights_m, "<f4").tobytes()

    def _thinned(self) -> Terrain:
        assert self._terrain is not None
        return thinned(self._terrain)


def _surfaces(part: ObstacleModel | PropEntry, terrain: Terrain) -> Iterator[Surface]:
    """Yield the surfaces of an obstacle, or those of a prop's obstacles, bodies and links at their start."""
    for obstacle in part.obstacles() if isinstance(part, PropEntry) else (part,):
        vertices, triangles, _ = obstacle_solid(obstacle, terrain)
        yield Surface(vertices, triangles, obstacle)
    for body in part.objects() if isinstance(part, PropEntry) else ():
        yield Surface(*object_start(body, terrain), body.shape)
        yield from _links(body, terrain)


def _links(body: LooseBody, terrain: Terrain) -> Iterator[Surface]:
    """Yield the surfaces of a body's links, each in the frame of what holds it."""
    shape, links = grounded(body.shape, terrain), body.links or {}
    assert isinstance(shape, Placed)
    frames: dict[str | None, tuple[Floats, Floats]] = {None: (np.asarray(shape.position_m), own_turn(body))}
    for name in links_in_order(links):
        link = links[name]
        place, turn = frames[link.on]
        place = place + turned(turn, link.position_m)
        turn = product(turn, of_yaw_pitch_roll_deg(link.yaw_pitch_roll_deg))
        if link.hinge is not None:
            axis, half = np.asarray(link.hinge.axis), 0.5 * math.radians(link.hinge.start_deg)
            turn = product(turn, [*math.sin(half) / np.linalg.norm(axis) * axis, math.cos(half)])
        elif link.slide is not None:
            axis = np.asarray(link.slide.axis)
            place = place + turned(turn, link.slide.start_m / np.linalg.norm(axis) * axis)
        frames[name] = place, turn
        if link.shape is not None:
            vertices, triangles = link_mesh(link)
            yield Surface(place + turned(turn, vertices), triangles, link.shape)
