"""The flight of the published lawn-mower, and the map that the processing chain builds from its pings (Fig. 12)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.channels import channels
from uwsim.channels.ros import build
from uwsim.channels.table import ORIGINS
from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.truth_and_map import draw_truth_and_map, render_truth_and_map
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap, ranging
from uwsim.missions.published_mower import BEAMS, FULL_AHEAD, Key, Seen, published_mower

CONTROL_S = 0.1
FALL_S = 5.0  # the published node's wait after the release
LONGEST_S = 2000.0
MAPPED_M = 0.5
VOXEL_M, REACH_M = 0.2, 95.0  # of the published octomap
ORIGIN_M = np.array(ORIGINS["published"])  # of the world, in odom


class Flight:
    """A flight in the `paper` scenario through its channels, as external nodes would fly it."""

    def __init__(self, live: LiveSimulator) -> None:
        self._live = live
        self._table = {c.name: c for c in channels(live.simulator, wire="published", origin="published")}
        self._last_ping = ""
        self.map, self.pings = OccupancyMap(VOXEL_M, on_outside="count"), 0
        self.track_m: list[tuple[float, float, float]] = []

    def fly(self) -> list[Key]:
        """Fly to the end; return the key messages sent. Raises RuntimeError if the flight takes too long."""
        mower, keys = published_mower(), []
        key = next(mower)
        while self._live.simulator.time_s < LONGEST_S:
            keys.append(key)
            message = build.pose((key.surge, key.sway, key.heave), (0.0, 0.0, key.yaw, key.function))
            self._table["key"].apply(self._live, message)
            self._live.step(round((FALL_S if key.function else CONTROL_S) / self._live.simulator.step_s))
            try:
                key = mower.send(self._look())
            except StopIteration:
                return keys
        raise RuntimeError(f"the lawn-mower did not end within {LONGEST_S:g} s")

    def _look(self) -> Seen:
        pose, text = self._read("propPos"), self._read("depthArray").data
        ranges = ranging.decode_depth_string(text, 2)
        if text != self._last_ping:
            self._last_ping = text
            self._insert(pose, ranges)
        turn = pose.orientation
        yaw_rad = float(Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_euler("ZYX")[0])
        position = pose.position.x, pose.position.y, pose.position.z
        self.track_m.append(position)
        first, middle, last = (float(ranges[beam]) for beam in BEAMS)
        return Seen(position, yaw_rad, (first, middle, last), float(self._read("proximitySensor").data))

    def _insert(self, pose: Any, ranges_m: NDArray[np.float32]) -> None:
        """Insert a ping as the published nodes do, at odom -> base_footprint -> base_scan."""
        odom_from_scan = _matrix(pose) @ _matrix(self._read("scanPos"))
        points_m = ranging.to_point_cloud(ranging.to_laser_scan(ranges_m, 2))
        self.map.insert_scan(ranging.transform_points(points_m, odom_from_scan), odom_from_scan[:3, 3], REACH_M)
        self.pings += 1

    def _read(self, topic: str) -> Any:
        return self._table[topic].read(self._live.simulator)


def _matrix(pose: Any) -> Floats:
    matrix, turn = np.eye(4), pose.orientation
    matrix[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    matrix[:3, 3] = pose.position.x, pose.position.y, pose.position.z
    return matrix


def bed_share(world: _core.World, track_m: Floats, voxels_m: Floats, range_max_m: float) -> float:
    """Return the mapped fraction of the bed within sonar range of a track; all positions (n, 3), world frame.

    The bed is sampled every metre; a sample is mapped if the centre of an occupied voxel is within half a metre.
    """
    low, high = (np.round(pick(track_m[:, :2], axis=0)) for pick in (np.min, np.max))
    x, y = np.meshgrid(*(np.arange(a - range_max_m, b + range_max_m) for a, b in zip(low, high, strict=True)))
    sides = np.stack([x.ravel(), y.ravel()], axis=1)
    bed_m = np.column_stack([sides, world.height_at(sides)])
    bed_m = bed_m[np.isfinite(bed_m[:, 2]) & (bed_m[:, 2] < 0.0)]
    within = bed_m[cKDTree(track_m).query(bed_m)[0] < range_max_m]
    return float(np.mean(cKDTree(voxels_m).query(within)[0] < MAPPED_M))


def mown_map(path: Path, map_file: Path) -> Figure:
    """Draw Fig. 12, the terrain beside the map, and write the map to map_file."""
    with LiveSimulator("paper", paused=True) as live:
        flight = Flight(live)
        keys = flight.fly()
        seconds, collisions = live.simulator.time_s, live.rov.collisions
        flight.map.write(map_file)
        track, voxels = np.array(flight.track_m), flight.map.occupied_voxels()
        sim, track_m, voxels_m = live.simulator, track - ORIGIN_M, voxels - ORIGIN_M
        mapped = bed_share(sim.world, track_m, voxels_m, live.rov.sonar.model.range_max_m)
        low, high = np.quantile(voxels_m[:, :2], (0.01, 0.99), axis=0)
        corners = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
        draw_truth_and_map(path, render_truth_and_map(sim.world, sim.scene, corners, voxels_m, VOXEL_M), track_m)
    first = next(number for number, key in enumerate(keys) if key.surge == FULL_AHEAD)
    depth_m = ORIGIN_M[2] - track[first:, 2]
    ahead = [key.surge == FULL_AHEAD for key in keys[1:]]
    lanes = sum(now and not before for before, now in zip([False, *ahead], ahead, strict=False))
    length_m = float(np.linalg.norm(np.diff(track, axis=0), axis=1).sum())
    return Figure(
        12, "The terrain and the 3D occupancy map",
        "The true terrain beside the OctoMap that the published lawn-mower leaves, in one view with the same colours "
        "by height.",
        "Theirs shows another terrain, which may not be copied; in its frame the surface is at z = 75.3 m.",
        values={"simulated_s": round(seconds, 1), "lanes": lanes, "pings": flight.pings,
                "path_m": round(length_m, 1), "collisions": collisions,
                "least_depth_m": round(float(depth_m.min()), 2), "greatest_depth_m": round(float(depth_m.max()), 2),
                "occupied_voxels": len(voxels), "voxel_m": VOXEL_M, "bed_mapped_percent": round(100.0 * mapped, 1)},
        columns=("x [m]", "y [m]", "z [m]"),
        rows=[tuple(round(value, 3) for value in point) for point in track[:: math.ceil(len(track) / 200)].tolist()],
    )  # fmt: skip
