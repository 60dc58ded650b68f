"""A Ping360: single pings of the vehicle's scanning sonar, whose head a motor turns in 400 steps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from brping import definitions as ids
from numpy.typing import NDArray

from uwsim.bridges.ping_protocol.device import Device, Values, intensities, within
from uwsim.bridges.ping_protocol.line import Line
from uwsim.instruments.sonars.imaging import ForwardLooking, look_ahead
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

TURN = 400
"""Gradians of a turn."""
AHEAD = 200
"""The head's angle in gradians at which it looks along the sonar's x axis. Angles grow clockwise, seen from above."""
TICK_S = 25e-9
"""The unit of the time between samples."""
STEP_NS = 20_000_000
"""The motor's time for a step: the maker's 9 s for a turn at 2 m and 35 s at 50 m, less the travel of sound."""
FULL_DB, GAINS_DB = 175.0, (-10.0, 0.0, 10.0)
"""The level whose intensity is 255, and the amplifications low, normal and high; assumed."""
LIMITS = {
    "gain_setting": (0, 2), "angle": (0, TURN - 1), "transmit_duration": (1, 1000), "sample_period": (80, 40_000),
    "transmit_frequency": (500, 1000), "number_of_samples": (200, 1200), "start_angle": (0, TURN - 1),
    "stop_angle": (0, TURN - 1), "num_steps": (1, 10), "delay": (0, 100),
}  # fmt: skip
START = {
    "mode": 1, "gain_setting": 0, "angle": 0, "transmit_duration": 32, "sample_period": 80, "transmit_frequency": 740,
    "number_of_samples": 200,
}  # fmt: skip


@dataclass(frozen=True)
class _Seen:
    """The state at a ping: the sonar, its pose, what is around it, and the speed of sound there."""

    time_ns: int
    model: ForwardLooking
    world_from_sonar: NDArray[np.float64]
    around: Any
    sound_m_s: float
    stream: str


class Ping360(Device):
    """A Ping360 in the place of an imaging sonar of kind `forward_looking`, of which it uses one beam.

    Frequency, number of samples and time between them are those that the program asks for. The answer to a ping comes
    in simulated time when the last sample has arrived and the head has made its step.
    """

    type = 2

    def __init__(self, live: LiveSimulator, vehicle: str, instrument: str, line: Line) -> None:
        super().__init__(live, vehicle, instrument, line)
        self._set: Values = dict(START)
        self._data = b""
        self._sector: Values | None = None
        self._along, self._step = 0, 1
        self.reports = dict.fromkeys((ids.PING360_DEVICE_DATA, ids.PING360_AUTO_DEVICE_DATA), self._state)
        self.commands = {
            ids.PING360_SET_DEVICE_ID: lambda values: self.rename(values["id"]),
            ids.PING360_RESET: self._reset,
            ids.PING360_TRANSDUCER: self._transducer,
            ids.PING360_AUTO_TRANSMIT: self._scan,
            ids.PING360_MOTOR_OFF: self._stop,
        }

    @property
    def is_driven(self) -> bool:
        """See Device."""
        return self._sector is not None

    def work(self) -> None:
        """Ping in the next direction of a scan."""
        if self._sector is None:
            return
        start, steps = self._sector["start_angle"], self._sector["num_steps"]
        self._ping((start + self._along) % TURN, ids.PING360_AUTO_DEVICE_DATA, self._sector["delay"] * 1_000_000)
        span = (self._sector["stop_angle"] - start) % TURN
        if span == TURN - 1:  # round and round
            self._along = (self._along + steps) % TURN
        else:
            if not 0 <= self._along + self._step * steps <= span:
                self._step = -self._step
            self._along = min(max(self._along + self._step * steps, 0), span)

    def _state(self) -> Values:
        sector = self._sector or {"start_angle": 0, "stop_angle": TURN - 1, "num_steps": 1, "delay": 0}
        return {**sector, **self._set, "data_length": len(self._data), "data": self._data}

    def _reset(self, values: Values) -> None:
        if values["bootloader"]:
            raise ValueError("bootloader: the simulated device has none")
        self._set, self._data, self._sector = dict(START), b"", None

    def _stop(self, values: Values) -> None:
        self._sector = None

    def _scan(self, values: Values) -> None:
        within(values, LIMITS)
        self._sector = {name: values.pop(name) for name in ("start_angle", "stop_angle", "num_steps", "delay")}
        self._set |= {**values, "mode": 1}
        self._along, self._step = 0, 1

    def _transducer(self, values: Values) -> bool:
        within(values, LIMITS)
        self._sector = None
        transmit = values.pop("transmit")
        self._set |= {**values, "mode": 1}
        del self._set["reserved"]
        if transmit:
            self._ping(self._set["angle"], ids.PING360_DEVICE_DATA)
        else:
            self.send(ids.PING360_DEVICE_DATA, self._state())
        return True

    def _ping(self, angle: int, answer: int, delay_ns: int = 0) -> None:
        self._set["angle"] = angle
        seen = self.capture(self._see)
        ping_s = self._set["number_of_samples"] * self._set["sample_period"] * TICK_S
        self._data = self._echoes(seen, 0.5 * ping_s * seen.sound_m_s)
        self.send_at(seen.time_ns, seen.time_ns + round(1e9 * ping_s) + STEP_NS + delay_ns, answer, self._state())

    def _see(self, sim: Simulator) -> _Seen:
        sonar = sim.vehicles[self._vehicle].imaging_sonars[self._instrument]
        pose = sonar.world_from_sonar
        speed_m_s = sim.world.water.sound_speed_m_s(min(float(pose[2, 3]), 0.0))
        model: Any = sonar.model
        return _Seen(sim.time_ns, model, pose, sim.around(self._vehicle), speed_m_s, sonar.stream)

    def _echoes(self, seen: _Seen, range_max_m: float) -> bytes:
        model = replace(
            seen.model, beams=1, frequency_hz=1e3 * self._set["transmit_frequency"], range_max_m=range_max_m,
            range_bins=self._set["number_of_samples"],
        )  # fmt: skip
        # A single beam looks to the edge of the field of view.
        bearing_rad = (AHEAD - self._set["angle"]) * 2 * np.pi / TURN + 0.5 * model.field_of_view_rad
        turned = np.eye(4)
        c, s = np.cos(bearing_rad), np.sin(bearing_rad)
        turned[:2, :2] = [[c, -s], [s, c]]
        image = look_ahead(seen.around, seen.world_from_sonar @ turned, model, name=seen.stream, number=seen.time_ns)
        return intensities(image.level_db[:, 0] + GAINS_DB[self._set["gain_setting"]], FULL_DB)
