"""A Ping1D: the height that the vehicle's altimeter measures, and the echoes of a beam that looks down from it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.ping_protocol.device import FIRMWARE, Device, Values, intensities, within
from uwsim.bridges.ping_protocol.line import Line
from uwsim.instruments.sonars.imaging import SingleBeam, profile
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

POINTS = 200
"""Points of a profile."""
BEAM = SingleBeam(frequency_hz=115e3, beam_width_rad=math.radians(30))
"""Frequency and beam: Blue Robotics, Ping sonar technical guide; levels as for the kind, assumed."""
GAINS_DB = tuple(20 * math.log10(gain) for gain in (0.6, 1.8, 5.5, 12.9, 30.2, 66.1, 144))
"""The amplifications that the protocol states for each gain setting."""
FULL_DB = 166.0
"""The level whose intensity is 255 at an amplification of 1; assumed."""
SURE_DB = 40.0
"""The height of an echo above the noise at which the confidence is 100 %; assumed."""
RANGES_MM = (1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000)
"""The lengths of the scan from which the automatic mode chooses; assumed."""
MARGIN = 1.25
LIMITS = {
    "speed_of_sound": (1_000_000, 2_000_000), "mode_auto": (0, 1), "ping_interval": (10, 60_000),
    "gain_setting": (0, 6), "ping_enabled": (0, 1), "scan_start": (0, 100_000), "scan_length": (200, 100_000),
}  # fmt: skip
SETTINGS = {
    1001: ("scan_start", "scan_length"), 1002: ("speed_of_sound",), 1003: ("mode_auto",), 1004: ("ping_interval",),
    1005: ("gain_setting",), 1006: ("ping_enabled",),
}  # fmt: skip
PROFILE = 1300
VOLTAGE_MV = 5000
BINS_MAX = 20_000


@dataclass(frozen=True)
class _Seen:
    """The state at a ping: the altimeter's height [m], NaN without an echo, the water there, and the beam's pose."""

    time_ns: int
    height_m: float
    sound_m_s: float
    temperature_deg_c: float
    around: Any
    world_from_beam: NDArray[np.float64]


class Ping1D(Device):
    """A Ping1D in the place of an altimeter.

    It pings at multiples of its interval in simulated time, as far as it is asked: a request gets the latest ping. The
    distance is the altimeter's sample; the profile and the confidence are from a beam straight down, with the levels of
    `single_beam`. Times become distances by the speed of sound that the device is set to, in water with its own.
    """

    type = 1

    def __init__(self, live: LiveSimulator, vehicle: str, instrument: str, line: Line) -> None:
        super().__init__(live, vehicle, instrument, line)
        self._set: Values = {
            "speed_of_sound": 1_500_000, "mode_auto": 1, "ping_interval": 100, "gain_setting": 0, "ping_enabled": 1,
            "scan_start": 0, "scan_length": RANGES_MM[-1],
        }  # fmt: skip
        self._ping: Values | None = None
        self._tick: int | None = None
        self._is_continuous = False
        self._temperature_deg_c = 0.0
        self.reports = {
            **dict.fromkeys((1203, 1205, 1206, 1215), lambda: self._set),
            1200: lambda: {"device_type": self.type, "device_model": 1, **FIRMWARE},
            1201: lambda: {"device_id": self._id},
            1202: lambda: {"voltage_5": VOLTAGE_MV},
            1204: self._scan, 1207: self._scan, 1208: self._newest,
            1210: lambda: {"voltage_5": VOLTAGE_MV, **FIRMWARE, **self._set, **self._scan()},
            1211: self._newest, 1212: self._newest, PROFILE: self._newest,
            1213: self._temperatures, 1214: self._temperatures,
        }  # fmt: skip
        self.commands = {
            **dict.fromkeys(SETTINGS, self._change),
            1000: lambda values: self.rename(values["device_id"]),
            1400: lambda values: self._stream(values, True),
            1401: lambda values: self._stream(values, False),
        }

    @property
    def is_driven(self) -> bool:
        """See Device."""
        return self._is_continuous

    def work(self) -> None:
        """Send a profile of each ping while the device has been asked to."""
        before = self._tick
        if self._is_continuous and self._set["ping_enabled"]:
            newest = self._newest()
            if self._tick != before:
                self.send(PROFILE, newest)

    def _change(self, values: Values) -> None:
        within(values, LIMITS)
        changed = {**self._set, **values}
        if POINTS * (changed["scan_start"] + changed["scan_length"]) > BINS_MAX * changed["scan_length"]:
            raise ValueError(f"scan_start: must be less than {BINS_MAX // POINTS - 1} times scan_length")
        self._set, self._tick = changed, None

    def _stream(self, values: Values, is_on: bool) -> None:
        if values["id"] != PROFILE:
            raise ValueError(f"id = {values['id']}: must be {PROFILE}")
        self._is_continuous = is_on

    def _scan(self) -> Values:
        """Return range and gain: those that were set, or that the automatic mode has chosen for the latest ping."""
        return self._newest() if self._set["mode_auto"] else self._set

    def _temperatures(self) -> Values:
        """Return the temperatures of the electronics, which are the water's."""
        self._newest()
        cdeg = round(100 * max(self._temperature_deg_c, 0.0))
        return {"processor_temperature": cdeg, "pcb_temperature": cdeg}

    def _newest(self) -> Values:
        """Return the fields of the latest ping, which is computed if it has not been."""
        number = self._live.time_ns // (1_000_000 * self._set["ping_interval"])
        if self._ping is None or (self._set["ping_enabled"] and number != self._tick):
            self._ping, self._tick = self._pinged(self.capture(self._see), number), number
        return self._ping

    def _see(self, sim: Simulator) -> _Seen:
        vehicle = sim.vehicles[self._vehicle]
        altimeter = vehicle.sensors[self._instrument]
        sample: Any = altimeter.sample()
        pose = np.eye(4)
        pose[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]  # x points down
        pose[:3, 3] = (vehicle.pose.world_from_body @ [*altimeter.spec.position_m, 1.0])[:3]
        water, z_m = sim.world.water, min(float(pose[2, 3]), 0.0)
        return _Seen(
            sim.time_ns,
            float(sample.value) if sample.valid else math.nan,
            water.sound_speed_m_s(z_m),
            water.temperature_deg_c(z_m),
            sim.around(self._vehicle),
            pose,
        )

    def _pinged(self, seen: _Seen, number: int) -> Values:
        mm_per_m = self._set["speed_of_sound"] / seen.sound_m_s  # as the device takes what is there
        found_mm = mm_per_m * seen.height_m
        start_mm, length_mm = self._set["scan_start"], self._set["scan_length"]
        if self._set["mode_auto"]:
            far_mm = MARGIN * found_mm
            start_mm, length_mm = 0, next((each for each in RANGES_MM if each >= far_mm), RANGES_MM[-1])
        end_mm = start_mm + length_mm
        bins = -(-POINTS * end_mm // length_mm)
        echoes = profile(
            seen.around, seen.world_from_beam, [0.0], replace(BEAM, range_max_m=end_mm / mm_per_m, range_bins=bins),
            name=f"{self._vehicle}/{self._instrument}/ping1d", first_ping=seen.time_ns,
        )  # fmt: skip
        level_db = echoes.level_db[0, -POINTS:]
        gain = self._set["gain_setting"]
        if self._set["mode_auto"]:  # the highest at which nothing is clipped
            gain = sum(level_db.max() + gain_db <= FULL_DB for gain_db in GAINS_DB[1:])
        is_found = start_mm <= found_mm <= end_mm
        above_db = float((level_db - echoes.noise_db[-POINTS:]).max())
        last_mm = 0 if self._ping is None else self._ping["distance"]
        self._temperature_deg_c = seen.temperature_deg_c
        return {
            "distance": round(found_mm) if is_found else last_mm,
            "confidence": round(100 * min(max(above_db / SURE_DB, 0.0), 1.0)) if is_found else 0,
            "transmit_duration": round(min(2e6 * length_mm / POINTS / self._set["speed_of_sound"], 10_000.0)),
            "ping_number": number % (1 << 32),
            "scan_start": start_mm,
            "scan_length": length_mm,
            "gain_setting": gain,
            "profile_data_length": POINTS,
            "profile_data": intensities(level_db + GAINS_DB[gain], FULL_DB),
        }
