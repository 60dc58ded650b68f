"""MapBuilder: queues point clouds until the transforms for their times have arrived, then inserts them in order."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.channels.ros import build
from uwsim.mapping import MapEngine, OccupancyMap, ranging

VOXEL_M = 0.2
CHAIN = (("odom", "base_footprint"), ("base_footprint", "base_scan"))
REMEMBERED = 500  # transforms per frame: 10 s at 50 Hz
WAITING = 200  # clouds
REACH_M = 95.0
BACK_NS = 1_000_000_000  # a larger step back in time is a restart of the simulation


class MapBuilder:
    """A map in odom with 0.2 m voxels, built by OctoMap's insertPointCloud, as in the paper, or by bricks.

    engine: "bricks" produces the same bytes much faster. inserted: the number of clouds in the map.
    """

    def __init__(self, engine: MapEngine = "octomap") -> None:
        self.map = OccupancyMap(VOXEL_M, engine=engine, on_outside="count")
        self.inserted = 0
        self._poses: dict[tuple[str, str], deque[tuple[int, NDArray[np.float64]]]] = {
            link: deque(maxlen=REMEMBERED) for link in CHAIN
        }
        self._clouds: deque[Any] = deque(maxlen=WAITING)

    def add_transforms(self, message: Any) -> None:
        """Store the transforms in a tf message that lead from odom to the sonar."""
        for stamped in message.transforms:
            link = stamped.header.frame_id, stamped.child_frame_id
            if link in self._poses:
                self._forget_before(stamp_ns := build.ns_of(stamped.header.stamp))
                self._poses[link].append((stamp_ns, _matrix(stamped.transform)))

    def add_cloud(self, message: Any) -> None:
        """Queue a cloud."""
        self._clouds.append(message)

    def insert_ready(self) -> int:
        """Insert the clouds whose transforms have arrived; return how many were inserted."""
        before = self.inserted
        while self._clouds and self._known(build.ns_of(self._clouds[0].header.stamp)):
            cloud = self._clouds.popleft()
            stamp_ns = build.ns_of(cloud.header.stamp)
            odom_from_body, body_from_scan = (self._nearest(link, stamp_ns) for link in CHAIN)
            odom_from_scan = odom_from_body @ body_from_scan
            points = np.frombuffer(cloud.data.tobytes(), np.float32).reshape(-1, cloud.point_step // 4)[:, :3]
            points_odom = ranging.transform_points(np.ascontiguousarray(points), odom_from_scan)
            self.map.insert_scan(points_odom, odom_from_scan[:3, 3], REACH_M)
            self.inserted += 1
        return self.inserted - before

    def _forget_before(self, stamp_ns: int) -> None:
        """Discard transforms and waiting clouds if time has gone back, since they would place clouds of the new run."""
        if any(poses and poses[-1][0] > stamp_ns + BACK_NS for poses in self._poses.values()):
            for poses in self._poses.values():
                poses.clear()
            self._clouds.clear()

    def write(self, path: Path) -> None:
        """Write the map."""
        self.map.write(path)

    def _known(self, stamp_ns: int) -> bool:
        return all(poses and poses[-1][0] >= stamp_ns for poses in self._poses.values())

    def _nearest(self, link: tuple[str, str], stamp_ns: int) -> NDArray[np.float64]:
        nearest, least_ns = self._poses[link][-1], BACK_NS * REMEMBERED
        for entry in reversed(self._poses[link]):  # a cloud is near the newest
            if (away_ns := abs(entry[0] - stamp_ns)) <= least_ns:
                nearest, least_ns = entry, away_ns
            if entry[0] < stamp_ns - least_ns - BACK_NS:  # none before it is nearer: see _forget_before
                break
        return nearest[1]


def _matrix(transform: Any) -> NDArray[np.float64]:
    matrix = np.eye(4)
    moved, turned = transform.translation, transform.rotation
    matrix[:3, :3] = Rotation.from_quat([turned.x, turned.y, turned.z, turned.w]).as_matrix()
    matrix[:3, 3] = moved.x, moved.y, moved.z
    return matrix
