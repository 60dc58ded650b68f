"""A DVL A50: reports and commands of one DVL of a vehicle, for the programs that are connected."""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.quaternions import matrix
from uwsim.base.texts.json_text import json_object
from uwsim.bridges.a50.reports import FORMAT, MIRROR, DeadReckoning, Measured, beams, error_m_s
from uwsim.bridges.doors.streams import LineServer
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

POLL_S = 0.05
"""Simulated time between looks at the DVL and at commands."""
REPORT_NS = 200_000_000
"""Simulated time between dead reckoning reports."""
END = b"\r\n"
TRIGGERS_MAX = 15
RANGE_MODE = "auto"
FLAGS = ("acoustic_enabled", "dark_mode_enabled", "periodic_cycling_enabled")
NUMBERS = {"speed_of_sound": (1000, 2000), "mounting_rotation_offset": (0, 360)}

logger = logging.getLogger("uwsim.a50")


class A50:
    """Sends each sample of a DVL, and the position by dead reckoning, and obeys commands while simulated time passes.

    Everything is between two steps, 20 times per simulated second, and takes 0.3 ms on average. The speed of sound is
    the water's until a program sets it; velocities and distances are then in proportion to it. Use it as a context.
    """

    def __init__(self, live: LiveSimulator, vehicle: str, instrument: str, server: LineServer, address: str) -> None:
        self.address = address
        self._live, self._vehicle, self._instrument, self._server = live, vehicle, instrument, server
        dvl = live.simulator.vehicles[vehicle].sensors[instrument]
        self._beams = beams(dvl.spec.parameters)
        self._reckoning = DeadReckoning()
        self._config: dict[str, Any] = {
            "speed_of_sound": round(_sound_m_s(live.simulator, live.simulator.vehicles[vehicle])),
            "acoustic_enabled": True, "dark_mode_enabled": False, "mounting_rotation_offset": 0.0,
            "range_mode": RANGE_MODE, "periodic_cycling_enabled": True,
        }  # fmt: skip
        self._commands: dict[str, Callable[[dict[str, Any]], Any]] = {
            "reset_dead_reckoning": lambda _: self._reckoning.reset(),
            "calibrate_gyro": lambda _: None,
            "trigger_ping": lambda _: self._trigger(),
            "get_config": lambda _: self._config,
            "set_config": self._set_config,
        }
        self._triggers = 0
        self._last_ns: int | None = None
        self._reported_ns: int | None = None
        self._due_ns = 0
        self._start_s = time.time() - 1e-9 * live.time_ns

    def __enter__(self) -> A50:
        period_s = min(POLL_S, self._live.simulator.vehicles[self._vehicle].sensors[self._instrument].period_s)
        self._subscription = self._live.every(period_s, self._look, self._server_send)
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self._subscription.cancel()
        self._server.close()

    def _server_send(self, reports: list[dict[str, Any]]) -> None:
        for client, line in self._server.lines():
            if not line.lstrip().startswith(b"{"):  # not a program for a DVL: a web page, perhaps
                self._server.drop(client)
                continue
            self._server.send(json.dumps(self.answer(line)).encode() + END, client)
        if reports:
            self._server.send(b"".join(json.dumps(each).encode() + END for each in reports))

    def _look(self, sim: Simulator) -> list[dict[str, Any]]:
        """Return the reports that are due."""
        if self._last_ns is not None and sim.time_ns < self._due_ns - REPORT_NS:  # time went back
            self._reckoning.reset()
            self._last_ns = self._reported_ns = None
            self._due_ns = 0
        vehicle = sim.vehicles[self._vehicle]
        dvl = vehicle.sensors[self._instrument]
        sample: Any = dvl.sample()
        found: list[dict[str, Any]] = []
        if sample.stamp_ns != self._last_ns and (self._config["acoustic_enabled"] or self._triggers):
            self._triggers = max(self._triggers - 1, 0)
            noise = dvl.spec.noise.get("beam_velocity", _core.NoiseSpec())
            measured = Measured.of(
                sample.value, sample.stamp_ns, self._beams, error_m_s(noise),
                is_valid=sample.valid and bool(sample.value.bottom_lock),
                scale=self._config["speed_of_sound"] / _sound_m_s(sim, vehicle),
                offset_rad=math.radians(self._config["mounting_rotation_offset"]),
            )  # fmt: skip
            since_ns = 0 if self._reported_ns is None else sim.time_ns - self._reported_ns
            found.append(measured.report(1e-6 * since_ns, self._unix_us(sample.stamp_ns), self._unix_us(sim.time_ns)))
            self._last_ns, self._reported_ns = sample.stamp_ns, sim.time_ns
            attitude = self._attitude(vehicle)
            if attitude is not None:
                self._reckoning.add(measured, attitude)
        if sim.time_ns >= self._due_ns and self._attitude(vehicle) is not None:
            self._due_ns = sim.time_ns - sim.time_ns % REPORT_NS + REPORT_NS
            found.append(self._reckoning.report(1e-6 * self._unix_us(sim.time_ns)))
        return found

    def _unix_us(self, time_ns: int) -> int:
        return round(1e6 * self._start_s + 1e-3 * time_ns)

    def _attitude(self, vehicle: Vehicle) -> Any:
        """Return the attitude of the A50's axes in the world, as the vehicle's IMU measures it; None without one."""
        imu = next((each for each in vehicle.sensors.values() if each.kind == "imu" and each.on), None)
        if imu is None:
            return None
        reading: Any = imu.read()
        world_from_body = matrix(reading.orientation_xyzw) @ matrix(imu.spec.orientation_xyzw).T
        dvl = matrix(vehicle.sensors[self._instrument].spec.orientation_xyzw)
        c, s = (f(math.radians(self._config["mounting_rotation_offset"])) for f in (math.cos, math.sin))
        return world_from_body @ dvl @ MIRROR @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def answer(self, line: bytes) -> dict[str, Any]:
        """Return the answer to a command."""
        name, result, error = "", None, ""
        try:
            command = json_object(line, "command")
            name = str(command.get("command", ""))[:40]
            if name not in self._commands:
                raise ValueError(f"unknown command; there are: {', '.join(self._commands)}")
            parameters = command.get("parameters") or {}
            if not isinstance(parameters, dict):
                raise ValueError("parameters: must be an object")
            result = self._commands[name](parameters)
        except (ValueError, RecursionError) as problem:
            error = str(problem) or "too deep"
        return {
            "response_to": name, "success": not error, "error_message": error, "result": result, "format": FORMAT,
            "type": "response",
        }  # fmt: skip

    def _trigger(self) -> None:
        if self._triggers >= TRIGGERS_MAX:
            raise ValueError("the queue is full")
        self._triggers += 1

    def _set_config(self, parameters: dict[str, Any]) -> None:
        for name, value in parameters.items():
            if name in FLAGS:
                if not isinstance(value, bool):
                    raise ValueError(f"{name}: must be true or false")
            elif name in NUMBERS:
                low, high = NUMBERS[name]
                if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
                    raise ValueError(f"{name}: must be in [{low}, {high}]")
            elif name != "range_mode":
                raise ValueError(f"{name[:40]}: unknown; there are: {', '.join(self._config)}")
            elif value != RANGE_MODE:
                raise ValueError(f"range_mode: must be {RANGE_MODE}; the simulated DVL has no other")
        self._config |= parameters


def _sound_m_s(sim: Simulator, vehicle: Vehicle) -> float:
    return sim.world.water.sound_speed_m_s(min(float(vehicle.pose.position_world_m[2]), 0.0))
