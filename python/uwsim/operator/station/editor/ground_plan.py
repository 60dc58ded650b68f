"""The plan of an edited scenario for the chart: its bed and the outlines of its obstacles."""

from __future__ import annotations

from functools import partial

import numpy as np

from uwsim.channels.guest import Values
from uwsim.operator.station.scene.scene import glb, plan_outline, thinned
from uwsim.scenario import Scenario
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.terrain import Terrain, build_terrain
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.spec.obstacle import ObstacleModel
from uwsim.scenario.spec.terrain import TerrainSpec


class GroundPlan:
    """The bed, solids and outlines of a scenario's obstacles, of which only those that have changed are made again.

    edition: increases with each change of an obstacle, bed_edition with each of the bed.
    """

    def __init__(self) -> None:
        self.outlines_m: list[list[list[float]]] = []
        self.edition = self.bed_edition = 0
        self._solids: list[tuple[Vertices, Triangles]] = []
        self._obstacles: tuple[ObstacleModel, ...] = ()
        self._spec: TerrainSpec | None = None
        self._terrain: Terrain | None = None

    def draw(self, scenario: Scenario) -> None:
        """Make the plan of a scenario. Raises ScenarioError, changing nothing, if an obstacle cannot be built."""
        is_same = scenario.terrain == self._spec and self._terrain is not None
        terrain = self._terrain if is_same else build_terrain(scenario.terrain)
        assert terrain is not None
        known = list(zip(self._obstacles, self.outlines_m, self._solids, strict=True)) if is_same else []
        outlines, solids = [], []
        for k, obstacle in enumerate(scenario.obstacles):
            made = next(((outline, solid) for each, outline, solid in known if each == obstacle), None)
            if made is None:  # a pipeline's outline is drawn without its solid, which may be impossible
                with scenario.source_file.errors_at("obstacles", k):
                    vertices, triangles, _ = obstacle_solid(obstacle, terrain)
                outline = plan_outline(obstacle, partial(np.asarray, vertices), np.zeros(2))
                made = (outline, (vertices, triangles))
            outlines.append(made[0])
            solids.append(made[1])
        self.edition += scenario.obstacles != self._obstacles or not is_same
        self.bed_edition += not is_same
        self._spec, self._terrain = scenario.terrain, terrain
        self._obstacles, self.outlines_m, self._solids = scenario.obstacles, outlines, solids

    def solid(self, edition: int, number: int) -> bytes:
        """Return an obstacle as binary glTF, b"" if a newer edition replaces it. Raises ValueError if it never was."""
        if 0 <= edition < self.edition:
            return b""
        if edition != self.edition or number >= len(self._solids):
            raise ValueError(f"obstacle {number} of edition {edition}: does not exist")
        return glb(self._solids[number], np.zeros(3))

    @property
    def grid(self) -> Values:
        """The grid of the bed's heights; see wire.editor.BedGrid."""
        grid = self._thinned()
        rows, columns = grid.heights_m.shape
        west_m, south_m = (float(value) for value in grid.origin_m[:2])
        return {
            "rows": rows, "columns": columns, "west_m": west_m, "south_m": south_m,
            "spacing_m": [grid.spacing_m, grid.spacing_m], "edition": self.bed_edition,
        }  # fmt: skip

    def heights(self) -> bytes:
        """Return the heights of the grid's points as float32, the southernmost row first."""
        return np.asarray(self._thinned().heights_m, "<f4").tobytes()

    def _thinned(self) -> Terrain:
        assert self._terrain is not None
        return thinned(self._terrain)
