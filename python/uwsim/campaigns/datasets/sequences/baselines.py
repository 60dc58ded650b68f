"""Baselines of a sequence: tracks that uwsim itself estimates from the instruments, and their errors.

reckoning  the navigation filter without its USBL: inertial sensors, DVL, depth and compass from a known start
filter     the navigation filter with all its aids, as known at that time
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.campaigns.datasets.sequences.tum import Tum
from uwsim.channels import Table
from uwsim.channels.delivery.pictures import RATE_HZ
from uwsim.channels.source import Source
from uwsim.navigation.estimation import Navigator, Start
from uwsim.navigation.estimation.protocols import Instrumented
from uwsim.simulator.onboard_navigation import ALIGNMENT_STD_M, ALIGNMENT_STD_M_S, new_navigator
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.simulator.vehicle import Vehicle

FOLDER, RECKONING, FILTER = "baselines", "reckoning", "filter"
ABSOLUTE = "usbl"


@dataclass(frozen=True)
class _Without:
    """A vehicle without its sensors of one kind, for a Navigator."""

    name: str
    sensors: Mapping[str, Any]


class Baselines:
    """The baselines of a vehicle, which start with the first reading, from its true pose as known at a surveyed dock.

    errors: after `close`, the RMS, the largest and the last error of position [m] of each baseline, at its own times.
    """

    def __init__(self, folder: Path, source: Source, table: Table) -> None:
        self.folder, self._source = folder / FOLDER, source
        pings = table.pings.get(source.name) if source.has_sonar else None
        self.rate_hz = RATE_HZ if pings is None else pings.rate_hz
        self._navigators: dict[str, Navigator] = {}
        self._poses: dict[str, list[Floats]] = {}
        self._times_ns: list[int] = []
        self._true_m: list[Floats] = []
        self.errors: dict[str, dict[str, float]] = {}

    def read(self, sim: Simulator) -> None:
        """Add the poses that the navigators know now."""
        vehicle = self._source.of(sim)
        self._navigators = self._navigators or _navigators(vehicle, sim)
        for name, navigator in self._navigators.items():
            self._poses.setdefault(name, []).append(np.array(navigator.pose.world_from_body))
        self._times_ns.append(sim.time_ns)
        self._true_m.append(np.array(vehicle.pose.position_world_m))

    def close(self) -> None:
        """Write a TUM file for each baseline, and keep its errors. Raises OSError."""
        self.folder.mkdir()
        for name, poses in self._poses.items():
            self._write(name, poses)

    def _write(self, name: str, poses: list[Floats]) -> None:
        from scipy.spatial.transform import Rotation  # slow to import

        file = Tum(self.folder / f"{name}.tum")
        for time_ns, pose in zip(self._times_ns, poses, strict=True):
            file.add(time_ns, pose[:3, 3].tolist(), Rotation.from_matrix(pose[:3, :3]).as_quat().tolist())
        file.close()
        off_m = np.linalg.norm(np.array([pose[:3, 3] for pose in poses]) - np.array(self._true_m), axis=1)
        found = {"rms_m": np.sqrt(np.mean(off_m**2)), "largest_m": off_m.max(), "last_m": off_m[-1]}
        self.errors[name] = {key: round(float(value), 4) for key, value in found.items()}


def _navigators(vehicle: Vehicle, sim: Simulator) -> dict[str, Navigator]:
    velocity = vehicle.pose.world_from_body[:3, :3] @ vehicle.velocity.linear_body_m_s
    start = Start(
        tuple(vehicle.pose.position_world_m.tolist()), ALIGNMENT_STD_M, tuple(velocity.tolist()), ALIGNMENT_STD_M_S
    )
    relative = {name: sensor for name, sensor in vehicle.sensors.items() if sensor.kind != ABSOLUTE}
    aboard: dict[str, Instrumented] = {RECKONING: _Without(vehicle.name, relative), FILTER: vehicle}
    return {name: new_navigator(each, start, sim.world.water) for name, each in aboard.items()}
