"""Targets for a camera: points on the surfaces of the world and of other vehicles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.named import did_you_mean
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.spec.obstacle import Part, places_by_kind
from uwsim.simulator.simulator import Simulator

TERRAIN = "terrain"
PLACE_M = 1e-3
"""Size of the triangle at a part's place."""
ABOVE = np.array([0.0, 0.0, 1.5])
"""Where the top of a piece of cover is looked for from, in sizes of the piece above its foot."""


class Targets:
    """Surfaces by name. All are chosen equally often, regardless of size."""

    def __init__(
        self, sim: Simulator, carrier: str, classes: dict[str, str], look_at: Sequence[str] | None,
        parts: Sequence[tuple[str, Part]] = (),
    ) -> None:  # fmt: skip
        """Collect the surfaces to look at; carrier is the camera's vehicle, which is not a target.

        classes: the class of each surface, by name. look_at: names and classes of surfaces. Raises ValueError for an
        unknown name or if nothing is left. parts: those of obstacles, which are targets only if look_at has their kind;
        likewise the pieces of cover, by the name or the class of their layer, and the fish of a school.
        """
        self._world = sim.world
        surfaces = {**_solids(sim), **_vehicles(sim, carrier)}
        if sim.world.highest_m > -np.inf:
            surfaces[TERRAIN] = np.empty((0, 3, 3))
        wanted_parts = {part.kind for _, part in parts} & set(look_at or ())
        for kind, places in places_by_kind(part for _, part in parts if part.kind in wanted_parts).items():
            surfaces[kind] = places[:, None] + PLACE_M * np.eye(3)
        classes = {**{kind: kind for kind in wanted_parts}, **classes}
        layers = [layer.name for layer in sim.scenario.cover]
        surfaces |= _tops(sim, [name for name in layers if {name, classes[name]} & set(look_at or ())])
        schools = {one.name: k for k, one in enumerate(sim.scenario.life or ())}
        self._schools = {name: k for name, k in schools.items() if {name, classes[name]} & set(look_at or ())}
        surfaces |= dict.fromkeys(self._schools, np.empty((0, 3, 3)))
        known = {*(part.kind for _, part in parts), *layers, *schools, *surfaces}
        known |= {classes[name] for name in (*surfaces, *layers, *schools)}
        for name in look_at or ():
            if name not in known:
                hint = did_you_mean(name, known)
                raise ValueError(f"look_at = {name!r}: must be one of {', '.join(sorted(known)) or 'none'}{hint}")
        wanted = [name for name in surfaces if not look_at or name in look_at or classes[name] in look_at]
        if not wanted:
            raise ValueError(f"scenario '{sim.scenario.name}': has no terrain and no obstacle to look at")
        self.names = wanted
        self._corners_m = {name: surfaces[name] for name in wanted}
        self._heaps = {name: np.cumsum(_areas_m2(surfaces[name])) for name in wanted}

    def swim(self, time_s: float) -> None:
        """Move the fish to where they are at a time."""
        for name, school in self._schools.items():
            corners = self._world.school_at(school, time_s)[0][:, None] + PLACE_M * np.eye(3)
            self._corners_m[name], self._heaps[name] = corners, np.cumsum(_areas_m2(corners))

    def draw(self, count: int, random: np.random.Generator) -> tuple[NDArray[np.intp], Floats]:
        """Return `count` random points (count, 3), and for each the index of its surface in `names`."""
        which = random.integers(len(self.names), size=count)
        shares = random.random((count, 3))
        points = np.empty((count, 3))
        for index in np.unique(which):
            chosen = which == index
            points[chosen] = self._points(self.names[index], shares[chosen])
        return which, points

    def _points(self, name: str, shares: Floats) -> Floats:
        """Map numbers (n, 3), uniform in [0, 1), to points distributed uniformly over a surface."""
        if name == TERRAIN:
            x0, y0, x1, y1 = self._world.terrain_extent_m
            xy = np.array([x0, y0]) + shares[:, :2] * np.array([x1 - x0, y1 - y0])
            return np.column_stack([xy, self._world.height_at(xy)])
        heap, corners = self._heaps[name], self._corners_m[name]
        a, b, c = np.moveaxis(corners[np.searchsorted(heap, shares[:, 0] * heap[-1], side="right")], 1, 0)
        root, v = np.sqrt(shares[:, 1:2]), shares[:, 2:3]
        return np.asarray((1 - root) * a + root * (1 - v) * b + root * v * c)


def _solids(sim: Simulator) -> dict[str, Floats]:
    """Return the corners (n, 3, 3) of each solid's triangles, by name."""
    vertices, triangles, labels = sim.world.surface_mesh(with_terrain=False)
    corners, names = vertices[triangles], sim.world.label_names
    return {names[label]: corners[labels == label] for label in np.unique(labels)}


def _tops(sim: Simulator, layers: Sequence[str]) -> dict[str, Floats]:
    """Return the corners (n, 3, 3) of small triangles on top of the pieces of layers of cover, by the layer's name."""
    if not layers:
        return {}
    low, high = np.reshape(sim.world.terrain_extent_m, (2, 2))
    places, sizes, labels, _ = sim.scene.cover_in(low, high)
    above, names = places + sizes[:, None] * ABOVE, sim.world.label_names
    down, reach_m = np.tile([0.0, 0.0, -1.0], (len(above), 1)), 2.0 * ABOVE[2] * float(sizes.max(initial=1.0))
    hits = sim.scene.cast(above, down, reach_m)
    tops = above - hits.ranges_m[:, None] * (0.0, 0.0, 1.0)
    seen = hits.labels == labels  # others lie below something else
    found = {name: tops[seen & (labels == names.index(name))] for name in layers}
    return {name: each[:, None] + PLACE_M * np.eye(3) for name, each in found.items() if len(each)}


def _vehicles(sim: Simulator, carrier: str) -> dict[str, Floats]:
    found = {}
    for entry in sim.scenario.vehicles:
        if entry.name != carrier:
            vertices, triangles = vehicle_hull(entry.model)
            pose = sim.vehicles[entry.name].pose.world_from_body
            found[entry.name] = (vertices @ pose[:3, :3].T + pose[:3, 3])[triangles]
    return found


def _areas_m2(corners: Floats) -> Floats:
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(across, axis=1))
