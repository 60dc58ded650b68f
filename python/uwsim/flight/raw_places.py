"""The side scan of a raw survey, the places of its pings, and errors of installation (a patch test).

The head is mounted as the vehicle's file states; the raw file is written as by a survey that assumes another mount, or
positions that arrive late. Software that calibrates must find the values given: roll, pitch and heading [deg] are
the true angle minus the assumed one (starboard down, bow up, clockwise), latency [s] is the age of a position,
and of its depth, that the survey takes for new.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.options import named_numbers
from uwsim.instruments.sonars.imaging import SideScan
from uwsim.instruments.sonars.soundings import sound_speed_profile
from uwsim.mapping.files.georeference import Georeference
from uwsim.mapping.files.side_scan_line import SideScanHead, SideScanLine, SideScanWriter
from uwsim.mapping.files.swath import EPOCH_NS
from uwsim.scenario import Scenario
from uwsim.scenario.georeference import georeference
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.simulator.vehicle import Vehicle


LIMITS = {
    "roll": (-10.0, 10.0, "deg"), "pitch": (-10.0, 10.0, "deg"), "heading": (-10.0, 10.0, "deg"),
    "latency": (0.0, 2.0, "s"),
}  # fmt: skip
HISTORY = 256  # pings; 2 s at any ping rate of an echo sounder


@dataclass(frozen=True)
class PatchErrors:
    """The errors; see the module."""

    roll: float = 0.0
    pitch: float = 0.0
    heading: float = 0.0
    latency: float = 0.0

    @classmethod
    def parse(cls, text: str) -> PatchErrors:
        """Return the errors in a text such as roll=0.5,latency=0.02. Raises ValueError, which names the key."""
        return cls(**named_numbers("--offsets", text, LIMITS))

    def __str__(self) -> str:
        units = {field.name: LIMITS[field.name][2] for field in fields(self)}
        return ", ".join(
            f"{name} {getattr(self, name):g} {unit}" for name, unit in units.items() if getattr(self, name)
        )

    @property
    def assumed_from_true(self) -> Floats:
        """The rotation (3, 3), body axes, from the head's true orientation to the one that the survey assumes."""
        roll, pitch, yaw = np.radians([self.roll, -self.pitch, -self.heading])
        cx, sx, cy, sy, cz, sz = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
        true_from_assumed = (
            np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
            @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
            @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        )
        return np.asarray(true_from_assumed.T, np.float64)


class ErringPoses:
    """Applies the errors to the poses of consecutive pings."""

    def __init__(self, errors: PatchErrors) -> None:
        self._errors, self._turn = errors, errors.assumed_from_true
        self._past: deque[tuple[float, Floats]] = deque(maxlen=HISTORY)

    def assumed(self, time_s: float, body: Floats, sonar: Floats) -> tuple[Floats, Floats]:
        """Return the poses (4, 4) of body and sonar that the survey assumes at the time of a ping.

        Positions between pings are interpolated; before the first ping, the vehicle is taken to rest.
        """
        self._past.append((time_s, body[:3, 3].copy()))
        times = np.array([each[0] for each in self._past])
        places = np.array([each[1] for each in self._past])
        late = np.array([np.interp(time_s - self._errors.latency, times, axis) for axis in places.T])
        seen = body.copy()
        seen[:3, 3] = late
        mount = np.linalg.inv(body) @ sonar
        mount[:3, :3] = self._turn @ mount[:3, :3]
        return seen, seen @ mount


STILL_M_S = 0.01  # below this speed, the course is the heading


def place_of_survey(scenario: Scenario, path: Path, option: str) -> Georeference:
    """Return a scenario's place on Earth. Raises ValueError, which names option and path, if it has none."""
    place = georeference(scenario)
    if place.crs is None:
        raise ValueError(f"{option} {path}: scenario '{scenario.name}': has no place on Earth: add earth: "
                         "{latitude_deg: ..., longitude_deg: ...}")  # fmt: skip
    if place.units_per_m != 1.0:
        raise ValueError(f"{option} {path}: scenario '{scenario.name}': horizontal_scale must be 1, since a "
                         "file for surveyors has no scale")  # fmt: skip
    return place


def angles(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = math.asin(min(1.0, max(-1.0, -rotation[2, 0])))
    return math.atan2(rotation[2, 1], rotation[2, 2]), pitch, math.atan2(rotation[1, 0], rotation[0, 0])


def level_axes(yaw_rad: float) -> Floats:
    """Return the axes (3, 3) of a level vehicle as rows, forward, starboard and down, in the world."""
    cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array([[cosine, sine, 0], [sine, -cosine, 0], [0, 0, -1]])


def estimated_covariance(vehicle: Vehicle, body: Floats, level: Floats) -> Floats:
    """Return the covariance (6, 6) of a vehicle's estimate at its reference point: place [m] and rotation [rad].

    body (4, 4): the estimated pose. level (3, 3): the axes of the result, see `level_axes`.
    """
    imu = next(each for each in vehicle.sensors.values() if each.kind == "imu")
    x, y, z = np.asarray(imu.spec.position_m, np.float64)
    found = np.eye(6)  # from the IMU's centre, world axes, and the attitude, body axes
    found[:3, :3] = level
    found[3:, 3:] = level @ body[:3, :3]
    found[:3, 3:] = level @ body[:3, :3] @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])  # p = p_imu - R r
    of_filter = vehicle.navigation.shown.covariance[np.ix_([0, 1, 2, 6, 7, 8], [0, 1, 2, 6, 7, 8])]
    return np.asarray(found @ of_filter @ found.T, np.float64)


class Motion:
    """Speed and course over ground between consecutive pings."""

    def __init__(self) -> None:
        self._last: tuple[int, Floats] | None = None

    def since_last(self, time_ns: int, position_m: Floats, heading_rad: float) -> tuple[float, float]:
        """Return speed over ground and course since the last ping; the heading while the vehicle is still."""
        last, self._last = self._last, (time_ns, position_m.copy())
        if last is None or time_ns <= last[0]:
            return 0.0, heading_rad
        east, north = (position_m - last[1])[:2] * 1e9 / (time_ns - last[0])
        speed_m_s = math.hypot(east, north)
        return speed_m_s, math.atan2(east, north) if speed_m_s > STILL_M_S else heading_rad


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

    def add(self, ping: Any, panel: object, world_from_body: Floats) -> None:
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

    def _head(self, body_from_sonar: Floats) -> SideScanHead:
        model = self._sonar.model
        assert isinstance(model, SideScan)
        return SideScanHead(
            vehicle=self._sim.rov.name, sonar=self._sonar.name, frequency_hz=model.frequency_hz,
            range_max_m=model.range_max_m, bins=model.range_bins, along_width_rad=model.along_width_rad,
            vertical_width_rad=model.vertical_width_rad, depression_rad=model.depression_rad,
            offset_m=body_from_sonar[:3, 3] * np.array([1.0, -1.0, -1.0]),
            comment=f"uwsim: scenario {self._sim.scenario.name}, seed {self._sim.seed}; simulated",
        )  # fmt: skip
