"""A flight's side scan as a raw survey for surveyors' software: `uwsim survey --raw FILE.xtf`."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.flight.raw_places import Array, Motion, angles, place_of_survey
from uwsim.instruments.sonars.imaging import SideScan
from uwsim.instruments.sonars.soundings import sound_speed_profile
from uwsim.mapping.files.side_scan_line import SideScanHead, SideScanLine, SideScanWriter
from uwsim.mapping.files.swath import EPOCH_NS
from uwsim.simulator.simulator import Simulator


class RawSideScan:
    """Writes a line of the first vehicle's first side-scan sonar with each mapped ping; `add` is a TakePing.

    Raises ValueError unless the scenario has a place on Earth and the vehicle has such a sonar.
    """

    def __init__(
        self, sim: Simulator, path: Path, write: Callable[[Path, SideScanHead], SideScanWriter], option: str = "--raw"
    ) -> None:
        self._sim, self._path, self._write = sim, path, write
        self._place = place_of_survey(sim.scenario, path, option)
        sonars = [each for each in sim.rov.imaging_sonars.values() if isinstance(each.model, SideScan)]
        if not sonars:
            raise ValueError(f"{option} {path}: holds side scan: '{sim.rov.name}' must have a sonar of kind side_scan")
        self._sonar = sonars[0]
        self._water = sound_speed_profile(sim.world.water)
        self._motion = Motion()
        self._file: SideScanWriter | None = None
        self.count = 0

    def add(self, ping: Any, panel: object, world_from_body: Array) -> None:
        """Write a line at a pose (4, 4) of the vehicle, taken at the true one."""
        line = self._sonar.line()
        true = np.asarray(self._sim.rov.pose.world_from_body, np.float64)
        body = np.asarray(world_from_body, np.float64)
        sonar = body @ np.linalg.inv(true) @ line.world_from_sonar[0]
        if self._file is None:
            self._file = self._write(self._path, self._head(np.linalg.inv(body) @ sonar))
        roll, pitch, yaw = angles(sonar[:3, :3])
        north_rad = self._place.north_rad(sonar[:3, 3])
        places = self._place.degrees(np.stack([body[:3, 3], sonar[:3, 3]]))
        speed_m_s, _ = self._motion.since_last(self._sim.time_ns, body[:3, 3], 0.0)
        self._file.add(SideScanLine(
            time_ns=EPOCH_NS + self._sim.time_ns, vehicle_deg=tuple(places[0].tolist()),
            sonar_deg=tuple(places[1].tolist()), sonar_depth_m=-float(sonar[2, 3]),
            altitude_m=float(line.altitude_m[0]), heading_rad=(math.pi / 2 - yaw + north_rad) % math.tau,
            pitch_rad=-pitch, roll_rad=roll, speed_m_s=speed_m_s,
            sound_speed_m_s=self._water.at(max(0.0, -float(sonar[2, 3]))), port_db=line.port_db[0],
            starboard_db=line.starboard_db[0],
        ))  # fmt: skip
        self.count += 1

    def close(self) -> None:
        """Complete the file. Raises ValueError if no ping was taken."""
        if self._file is None:
            raise ValueError(f"--raw {self._path}: no ping was taken, and nothing written")
        self._file.close()

    def discard(self) -> None:
        """Remove what was written of a flight that failed."""
        if self._file is not None:
            self._file.discard()

    def _head(self, body_from_sonar: Array) -> SideScanHead:
        model = self._sonar.model
        assert isinstance(model, SideScan)
        return SideScanHead(
            vehicle=self._sim.rov.name, sonar=self._sonar.name, frequency_hz=model.frequency_hz,
            range_max_m=model.range_max_m, bins=model.range_bins, along_width_rad=model.along_width_rad,
            vertical_width_rad=model.vertical_width_rad, depression_rad=model.depression_rad,
            offset_m=body_from_sonar[:3, 3] * np.array([1.0, -1.0, -1.0]),
            comment=f"uwsim: scenario {self._sim.scenario.name}, seed {self._sim.seed}; simulated",
        )  # fmt: skip
