"""Scenes for Foxglove's 3D panel: the lake, the hulls and their tracks, loose bodies, and the growing map."""

from __future__ import annotations

from typing import Any

import numpy as np
from foxglove.messages import (
    Color,
    Pose,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneEntityDeletionType,
    SceneUpdate,
    Vector3,
)
from numpy.typing import NDArray

from uwsim.bridges.foxglove.primitives import by_height, cubes, line, mesh
from uwsim.channels.delivery.feed import Reading
from uwsim.channels.families.map_changes import EDGE, OCCUPIED
from uwsim.scenario import Scenario, vehicle_hull
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.station import station_mesh
from uwsim.scenario.build.terrain import build_terrain
from uwsim.simulator.moving_shapes import MovingShape, moving_shapes

GRID_MAX = 160  # maximum number of heights along an edge of the displayed bed
STONE, STEEL = Color(r=0.55, g=0.53, b=0.5, a=1.0), Color(r=0.75, g=0.78, b=0.8, a=1.0)
HULL, PATH = Color(r=0.95, g=0.75, b=0.1, a=1.0), Color(r=0.95, g=0.4, b=0.1, a=1.0)
SEGMENT = 200  # positions per entity of a track: only the last entity is resent as the track grows
TRACK_STEP_M = 0.2
TRIANGLES_MAX = 2000  # of a loose body, whose surface is sent again as it moves
MOVED_M, MOVED_RAD = 0.01, 0.01
BODY = Color(r=0.8, g=0.45, b=0.25, a=1.0)
Surface = tuple[NDArray[np.floating], NDArray[np.integer]]
Position = tuple[float, float, float]
Positions = dict[str, Position]
"""Positions by vehicle."""


def lake(scenario: Scenario) -> SceneUpdate:
    """Return the scene of the bed (coloured by height), the obstacles and the station, in the world frame."""
    terrain = build_terrain(scenario.terrain)
    stride = max(1, -(-(max(terrain.heights_m.shape) - 1) // (GRID_MAX - 1)))
    heights = terrain.heights_m[::stride, ::stride]
    entities = [mesh("bed", "world", *_grid(heights, stride * terrain.spacing_m, terrain.origin_m))]
    for obstacle in scenario.obstacles:
        vertices, triangles, _ = obstacle_solid(obstacle, terrain)
        entities.append(mesh(obstacle.name, "world", vertices, triangles, STONE))
    if scenario.station.mesh is not None:
        entities.append(mesh("station", "world", *station_mesh(scenario.station), STEEL))
    return SceneUpdate(entities=entities)


def _grid(
    heights_m: NDArray[np.float32], spacing_m: float, origin_m: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Triangulate a height grid with two triangles per cell, as in the world; return vertices and triangles."""
    rows, columns = heights_m.shape
    y, x = np.mgrid[:rows, :columns] * spacing_m
    vertices = np.column_stack([x.ravel() + origin_m[0], y.ravel() + origin_m[1], heights_m.ravel()])
    k = np.arange(rows * columns).reshape(rows, columns)
    west, east, north, far = k[:-1, :-1].ravel(), k[:-1, 1:].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel()
    return vertices, np.concatenate([np.column_stack([west, east, north]), np.column_stack([east, far, north])])


def hulls(scenario: Scenario, frames: dict[str, str]) -> SceneUpdate:
    """Return the vehicle hulls, each fixed in its body frame. frames: the body frame of each vehicle."""
    return SceneUpdate(
        entities=[
            mesh(entry.name, frames[entry.name], *vehicle_hull(entry.model), HULL, frame_locked=True)
            for entry in scenario.vehicles
        ]
    )


class Bodies:
    """Loose bodies and links of arms at their poses, in the world frame. A body is sent again only when it has moved.

    A surface of more than TRIANGLES_MAX triangles is drawn as its convex hull, with which it collides.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._surfaces: dict[str, Surface] = {}
        self._poses: dict[str, NDArray[np.float64]] = {}

    def moved(self, now: dict[str, NDArray[np.float64]], time_ns: int) -> SceneUpdate | None:
        """Take poses by name, each x, y, z [m] and a quaternion x, y, z, w; return the bodies that have moved."""
        changed = [name for name, pose in now.items() if name not in self._poses or _has_moved(self._poses[name], pose)]
        self._poses |= {name: now[name] for name in changed}
        return SceneUpdate(entities=[self._entity(name, time_ns) for name in changed]) if changed else None

    def whole(self, time_ns: int) -> SceneUpdate | None:
        """Return all bodies, for a new client; None before the first poses."""
        entities = [self._entity(name, time_ns) for name in self._poses]
        return SceneUpdate(entities=entities) if entities else None

    def _entity(self, name: str, time_ns: int) -> SceneEntity:
        if not self._surfaces:
            self._surfaces = {body.name: _surface(body) for body in moving_shapes(self._scenario)}
        x, y, z, *turn = self._poses[name].tolist()
        pose = Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(**dict(zip("xyzw", turn, strict=True))))
        return mesh(name, "world", *self._surfaces[name], BODY, pose=pose, time_ns=time_ns)


def _surface(body: MovingShape) -> Surface:
    vertices, triangles = body.mesh()
    if len(triangles) <= TRIANGLES_MAX:
        return vertices, triangles
    from uwsim.base.whole_trimesh import trimesh

    hull = trimesh.convex.convex_hull(vertices)
    return np.asarray(hull.vertices), np.asarray(hull.faces)


def _has_moved(before: NDArray[np.float64], now: NDArray[np.float64]) -> bool:
    """Return True if a pose differs by at least MOVED_M or MOVED_RAD."""
    turned_rad = 2.0 * np.arccos(min(abs(float(before[3:] @ now[3:])), 1.0))
    return bool(np.linalg.norm(now[:3] - before[:3]) >= MOVED_M or turned_rad >= MOVED_RAD)


class Tracks:
    """Vehicle tracks since the first subscription, in the world frame."""

    def __init__(self) -> None:
        self._positions: dict[str, list[Position]] = {}

    def grown(self, now: Positions, time_ns: int) -> SceneUpdate | None:
        """Add positions; return the segments that have changed."""
        changed = []
        for name, position in now.items():
            track = self._positions.setdefault(name, [])
            if np.isfinite(position).all() and (
                not track or np.linalg.norm(np.subtract(position, track[-1])) >= TRACK_STEP_M
            ):
                track.append(position)
                changed.append(self._segment(name, (len(track) - 1) // SEGMENT, time_ns))
        return SceneUpdate(entities=changed) if changed else None

    def whole(self, time_ns: int) -> SceneUpdate | None:
        """Return all segments."""
        segments = [
            self._segment(name, number, time_ns)
            for name, track in self._positions.items()
            for number in range(-(-len(track) // SEGMENT))
        ]
        return SceneUpdate(entities=segments) if segments else None

    def _segment(self, name: str, number: int, time_ns: int) -> SceneEntity:
        begin = max(number * SEGMENT - 1, 0)  # joined to the previous segment
        positions = self._positions[name][begin : (number + 1) * SEGMENT]
        return line(f"{name} {number}", "world", positions, PATH, 2.0, time_ns)


Block = tuple[int, int, int]


class MapBlocks:
    """The map's occupied voxels as cubes. Each block of 16 x 16 x 16 voxels is an entity, resent when it changes."""

    def __init__(self) -> None:
        self._cells: dict[Block, set[int]] = {}
        self._sequence = -1
        self._newest: Reading | None = None

    def time_ns(self) -> int:
        """Return the time of the most recent changes."""
        return 0 if self._newest is None else self._newest.time_ns

    def forget(self) -> None:
        """Have no map for a new client until the next message."""
        self._newest = None

    def changed(self, reading: Reading) -> SceneUpdate | None:
        """Apply a MapChanges message; return the blocks that changed, or None if the message is out of date."""
        message = reading.message
        deletions = []
        if message.snapshot:
            self._cells.clear()
            deletions.append(SceneEntityDeletion(type=SceneEntityDeletionType.All))
        elif message.sequence <= self._sequence:
            return None
        self._sequence, self._newest = message.sequence, reading
        touched = []
        ends = np.cumsum(message.counts)
        for (x, y, z), end, count in zip(message.blocks.reshape(-1, 3).tolist(), ends, message.counts, strict=True):
            cells = self._cells.setdefault((x, y, z), set())
            for cell in message.cells[end - count : end].tolist():
                (cells.add if cell & OCCUPIED else cells.discard)(cell & (OCCUPIED - 1))
            touched.append((x, y, z))
        return SceneUpdate(deletions=deletions, entities=self._entities(touched, reading))

    def whole(self) -> SceneUpdate | None:
        """Return all blocks, for a new client."""
        if self._newest is None:
            return None
        deletions = [SceneEntityDeletion(type=SceneEntityDeletionType.All)]
        return SceneUpdate(deletions=deletions, entities=self._entities(list(self._cells), self._newest))

    def _entities(self, blocks: list[Block], reading: Reading) -> list[SceneEntity]:
        return [self._entity(block, reading.message, reading.time_ns) for block in blocks]

    def _entity(self, block: Block, message: Any, time_ns: int) -> SceneEntity:
        cells = np.array(sorted(self._cells[block]), np.int64)
        inside = np.column_stack([cells & 15, cells >> 4 & 15, cells >> 8 & 15])
        centres_m = (EDGE * np.array(block) + inside + 0.5) * message.resolution
        colors = by_height(centres_m[:, 2], bands_m=10.0) if len(cells) else []
        return cubes(
            "map {} {} {}".format(*block), message.header.frame_id, centres_m, colors, message.resolution, time_ns
        )
