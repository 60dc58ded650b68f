"""The world for the page's 3D view: the bed as a height grid, and obstacles, station and hulls as GLB."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.channels.guest import Values
from uwsim.channels.source import Source
from uwsim.operator.station.scene.basin import Basin, basin_among
from uwsim.scenario import start_pose, vehicle_hull
from uwsim.scenario.build.camera import obstacle_texture, station_texture
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.station import station_at_start, station_mesh
from uwsim.scenario.build.terrain import Terrain, build_terrain
from uwsim.scenario.obstacles.pipeline import Pipeline
from uwsim.scenario.read.mesh_file import Vertices
from uwsim.scenario.read.textures import Texture, triangle_means
from uwsim.scenario.spec.obstacle import ObstacleModel
from uwsim.simulator.simulator import Simulator

T = TypeVar("T")
GRID_MAX = 256  # maximum number of points along an edge of the grid
LOOK_BACK_M, LOOK_UP_M, LOOK_NEAR_M = 34.0, 24.0, 6.0  # the first view of a vehicle, as later ones in map3d/scene.js
LOOK_SHARES = (1.0, 0.6, 0.35)  # of that distance; the nearer ones where something hides the vehicle from all sides
LOOK_ANGLES_RAD = np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120, 150, -150, 180])
Mesh = tuple[NDArray[np.float64], NDArray[np.integer]]


class Scene:
    """Parts of a simulator's world, generated on first request and cached. Methods may be called on any thread."""

    def __init__(self, sim: Simulator, sources: list[Source]) -> None:
        self._scenario = sim.scenario
        self._rays = sim.scene
        self._sources = sources
        self._origin_m = sources[0].origin_m
        self._lock = threading.RLock()  # a mesh may need the terrain
        self._made: dict[str, Any] = {}
        self.hidden: frozenset[str] = frozenset()  # names of obstacles that pilots must find

    def described(self) -> Values:
        """Return the content of `scene.json`. Positions are in odom, like everything else on the wire."""
        grid, basin, station = self.grid(), self._basin(), station_at_start(self._scenario)
        shift_m = self._origin_m[:2]
        bed = described_grid(grid.heights_m, grid.origin_m + shift_m, grid.spacing_m)
        return {
            "terrain": {"url": "/scene/terrain.f32", **bed},
            "chart": None if basin is None else {
                "url": "/scene/chart.f32", "meshes": list(basin.names),
                **described_grid(basin.heights_m, basin.corner_m + shift_m, basin.spacing_m),
            },
            "meshes": [
                {
                    "name": name, "label": label, "url": f"/scene/mesh/{k}.glb",
                    "outline_m": self._once(f"outline {k}", partial(self._outline, name, make)),
                    "colour": self._colour(name),
                }
                for k, (name, label, make) in enumerate(self._solids())
            ],
            "vehicles": [
                {"name": s.name, "url": f"/scene/vehicle/{s.name}.glb", "look_m": look}
                for s, look in zip(self._sources, self._once("looks", self._looks), strict=True)
            ],
            "station_m": (np.asarray(station.position_m) + self._origin_m).tolist(),
            "surface_m": float(self._origin_m[2]),
        }  # fmt: skip

    def _basin(self) -> Basin | None:
        """Return the ground that the chart shows in place of the terrain, or None."""

        def meshes() -> dict[str, Mesh]:
            return {name: make() for name, kind, make in self._solids() if kind == "mesh"}

        return self._once("basin", lambda: basin_among(meshes()))

    def _looks(self) -> list[list[float]]:
        """Return for each vehicle the first eye [m] from its start, where nothing stands between them."""
        return [free_look(self._rays, *start_pose(self._scenario, source.entry)) for source in self._sources]

    def _colour(self, name: str) -> list[float] | None:
        """Return the albedo of a mesh, red, green and blue, or None if its material has its kind's."""
        bodies = {each.name: each.material for each in self._scenario.obstacles} | {
            "station": self._scenario.station.material
        }
        colour = bodies[name].colour
        return None if colour is None else list(colour)

    def _texture(self, name: str) -> Texture | None:
        """Return the colours that a mesh has in place of one."""
        found = next((each for each in self._scenario.obstacles if each.name == name), None)
        return station_texture(self._scenario.station) if found is None else obstacle_texture(found, self._scenario)

    def _outline(self, name: str, make: Callable[[], Mesh]) -> list[list[float]]:
        found = next((each for each in self._scenario.obstacles if each.name == name), None)
        return plan_outline(found, lambda: make()[0], self._origin_m[:2])

    def grid(self) -> Terrain:
        """Return the terrain, thinned to GRID_MAX points along an edge."""
        return self._once("grid", lambda: thinned(self._terrain()))

    def heights(self) -> bytes:
        """Return the content of `terrain.f32`."""
        return np.asarray(self.grid().heights_m + self._origin_m[2], "<f4").tobytes()

    def chart(self) -> bytes:
        """Return the content of `chart.f32`. Raises ValueError if the chart shows the terrain."""
        if (basin := self._basin()) is None:
            raise ValueError("the chart shows the terrain")
        return np.asarray(basin.heights_m + self._origin_m[2], "<f4").tobytes()

    def mesh(self, number: int) -> bytes:
        """Return an obstacle or the station as GLB. Raises ValueError if there is no mesh with this number."""
        solids = self._solids()
        if not 0 <= number < len(solids):
            raise ValueError(f"mesh {number}: there are {len(solids)}")
        name, _, make = solids[number]

        def made() -> bytes:
            mesh = make()
            return glb(mesh, self._origin_m, own_colours(self._texture(name), len(mesh[1])))

        return self._once(f"mesh {number}", made)

    def hull(self, name: str) -> bytes:
        """Return a vehicle's hull as GLB, in body axes. Raises ValueError for an unknown vehicle."""
        models = {source.name: source.entry.model for source in self._sources}
        if name not in models:
            raise ValueError(f"vehicle '{name[:40]}': does not exist")
        return self._once(f"hull {name}", lambda: glb(vehicle_hull(models[name]), np.zeros(3)))

    def _terrain(self) -> Terrain:
        return self._once("terrain", lambda: build_terrain(self._scenario.terrain))

    def _solids(self) -> list[tuple[str, str, Callable[[], Mesh]]]:
        found: list[tuple[str, str, Callable[[], Mesh]]] = [
            (obstacle.name, obstacle.kind, lambda o=obstacle: obstacle_solid(o, self._terrain())[:2])  # type: ignore[misc]
            for obstacle in self._scenario.obstacles
            if obstacle.name not in self.hidden
        ]
        if self._scenario.station.mesh is not None:
            found.append(("station", "station", lambda: station_mesh(self._scenario.station)))
        return found

    def _once(self, key: str, make: Callable[[], T]) -> T:
        with self._lock:
            if key not in self._made:
                self._made[key] = make()
            made: T = self._made[key]
            return made


def free_look(rays: _core.RayScene, position_m: Sequence[float], yaw_rad: float) -> list[float]:
    """Return the eye [m] relative to a vehicle, nearest to behind it and above, from which nothing hides the vehicle.

    What is within LOOK_NEAR_M of the vehicle, such as its dock, is ignored. Return the eye behind it if none is free.
    """
    headings_rad = yaw_rad + np.pi + LOOK_ANGLES_RAD
    up_m = np.full_like(headings_rad, LOOK_UP_M)
    eyes_m = np.column_stack([LOOK_BACK_M * np.cos(headings_rad), LOOK_BACK_M * np.sin(headings_rad), up_m])
    length_m = float(np.hypot(LOOK_BACK_M, LOOK_UP_M))
    for share in LOOK_SHARES:
        far_m = share * length_m
        hits = rays.cast(np.asarray(position_m) + share * eyes_m, -eyes_m / length_m, far_m)
        free = np.flatnonzero(~(hits.ranges_m < far_m - LOOK_NEAR_M))
        if free.size:
            return [round(float(each), 3) for each in share * eyes_m[free[0]]]
    return [round(float(each), 3) for each in eyes_m[0]]


def thinned(terrain: Terrain) -> Terrain:
    """Return every n-th height along both axes, so that no edge has more than GRID_MAX points."""
    stride = -(-(max(terrain.heights_m.shape) - 1) // (GRID_MAX - 1)) or 1
    return Terrain(terrain.heights_m[::stride, ::stride], stride * terrain.spacing_m, terrain.origin_m)


def described_grid(heights_m: NDArray[np.floating], corner_m: Any, spacing_m: float) -> Values:
    """Return a grid of heights, (rows, columns) from its south-western corner (x, y), as the page needs it."""
    (rows, columns), (west_m, south_m) = heights_m.shape, map(float, corner_m)
    both_m = [spacing_m, spacing_m]
    return {"rows": rows, "columns": columns, "west_m": west_m, "south_m": south_m, "spacing_m": both_m}


def plan_outline(
    obstacle: ObstacleModel | None, vertices: Callable[[], Vertices], shift_m: NDArray[np.float64]
) -> list[list[float]]:
    """Return the outline of a solid on the chart; of a pipeline, both its sides. shift_m: added to all corners."""
    if isinstance(obstacle, Pipeline):
        return strip(np.asarray(obstacle.points_m) + shift_m, obstacle.radius_m)
    return outline(vertices()[:, :2] + shift_m)


def outline(points_m: NDArray[np.float64]) -> list[list[float]]:
    """Return the corners (x, y) of the convex outline of points (n, 2)."""
    from scipy.spatial import ConvexHull

    return rounded(points_m[ConvexHull(points_m).vertices])


def strip(line_m: NDArray[np.float64], half_width_m: float) -> list[list[float]]:
    """Return the corners (x, y) of a strip along a gently bending line (n, 2), first along the left side, then back."""
    ways = np.diff(line_m, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    before, after = np.concatenate([ways[:1], ways]), np.concatenate([ways, ways[-1:]])
    along = (before + after) / (1.0 + np.sum(before * after, axis=1))[:, None]  # longer at corners, which are mitred
    left_m = half_width_m * np.column_stack([-along[:, 1], along[:, 0]])
    return rounded(np.concatenate([line_m + left_m, (line_m - left_m)[::-1]]))


def rounded(corners_m: NDArray[np.float64]) -> list[list[float]]:
    """Return corners (n, 2) as lists, in whole millimetres."""
    return [[round(float(x), 3), round(float(y), 3)] for x, y in corners_m]


def own_colours(texture: Texture | None, count: int) -> NDArray[np.float64] | None:
    """Return the albedo (count, 3) of each triangle of a mesh; None without a texture, or for that of others."""
    return triangle_means(texture) if texture is not None and len(texture.corners) == count else None


def glb(mesh: Mesh, offset_m: NDArray[np.float64], colours: NDArray[np.float64] | None = None) -> bytes:
    """Return a mesh as binary glTF without transforms. The z axis is up, as in the world, despite glTF's convention.

    colours: of its triangles, linear, (m, 3).
    """
    from uwsim.base.whole_trimesh import trimesh

    vertices, triangles = np.asarray(mesh[0]) + offset_m, np.asarray(mesh[1])
    if colours is not None:
        colours = np.repeat(np.rint(255.0 * colours).astype(np.uint8), 3, axis=0)
        vertices, triangles = vertices[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
    solid = trimesh.Trimesh(vertices, triangles, vertex_colors=colours, process=False)
    return cast(bytes, solid.export(file_type="glb"))
