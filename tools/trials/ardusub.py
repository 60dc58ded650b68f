"""A compiled ArduSub flies in lockstep through its modes, twice.

A single thread makes the steps and sends MAVLink messages while the firmware waits for a line, so that each message
arrives at the same frame in each run. ArduSub gets its position from the vehicle's own navigation (IMU, compass, DVL,
depth) as ODOMETRY; see uwsim.bridges.firmware.flight.
"""

from __future__ import annotations

import argparse
import hashlib
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from pymavlink.dialects.v20 import ardupilotmega as dialect

from uwsim import Simulator
from uwsim.bridges.ardusub import ArduSub, prepared
from uwsim.bridges.firmware.flight import firmware_flying
from uwsim.bridges.firmware.pilot import FirmwarePilot
from uwsim.bridges.mavlink.earth import HOME
from uwsim.recording import Recorder
from uwsim.recording.diff import diff
from uwsim.recording.reader import Recording
from uwsim.scenario import load

START_M = (-15.0, -16.0, -1.0)
PARAMETERS = {
    "LOG_BACKEND_TYPE": 0, "FS_GCS_ENABLE": 2, "BATT_LOW_VOLT": 10, "BATT_FS_LOW_ACT": 2, "LEAK1_TYPE": 1,
    "LEAK1_PIN": 1, "LEAK1_LOGIC": 0, "FS_LEAK_ENABLE": 1,
}  # fmt: skip


class Trial(FirmwarePilot):
    """A pilot that also uploads missions."""

    def __init__(self, ardusub: ArduSub) -> None:
        super().__init__(ardusub)
        self.reached: set[int] = set()
        self._asked: list[Any] = []

    def _take(self, message: Any) -> None:
        super()._take(message)
        if message.get_type() == "MISSION_ITEM_REACHED":
            self.reached.add(message.seq)
        elif message.get_type() == "MISSION_REQUEST" and message.seq < len(self._asked):
            self.send(self._asked[message.seq])

    def upload(self, points_ned_m: list[Any]) -> None:
        """Upload a mission of waypoints."""
        self._asked = []
        for seq, (north, east, down) in enumerate([(0, 0, 0), *points_ned_m]):
            lat, lon = HOME.degrees(np.array([east, north, -down]))
            self._asked.append(
                dialect.MAVLink_mission_item_int_message(
                    1, 1, seq, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT, 16, 0, 1, 0, 0.5, 0, 0, round(1e7 * lat),
                    round(1e7 * lon), -down,
                )
            )  # fmt: skip
        self.send(dialect.MAVLink_mission_count_message(1, 1, len(self._asked)))
        self.fly(5, lambda: "MISSION_ACK" in self.messages)


def spread(track: list[Any], axes: slice | int) -> float:
    """Return the largest distance of a track's positions from their mean [m]."""
    points = np.array(track)[:, axes].reshape(len(track), -1)
    return float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())


Row = tuple[str, float, float]
"""Name of a check, measured value, largest value that passes."""


def flights(trial: Trial) -> Iterator[Row]:
    """Fly in each mode; yield the measured values."""
    trial.get_ready()
    trial.arm()
    yield "not armed", float(not trial.armed), 0
    trial.mode("ALT_HOLD")
    trial.steer(z=200)
    trial.fly(60, lambda: trial.ned_m[2] > 3.5)
    trial.steer()
    trial.fly(5)
    yield "ALT_HOLD: depth over 20 s [m]", spread(trial.fly(20), 2), 0.1
    trial.mode("STABILIZE")
    yaw = trial.sim.rov.pose.yaw_rad
    trial.steer(x=300)
    trial.fly(5)
    trial.steer()
    trial.fly(5)
    yield "STABILIZE: heading while flying ahead [rad]", abs(trial.sim.rov.pose.yaw_rad - yaw), 0.1
    trial.mode("MANUAL")
    before = trial.ned_m
    trial.steer(y=500)
    trial.fly(4)
    trial.steer()
    yield "MANUAL: 0.3 m less the way by the lateral stick [m]", 0.3 - float(np.linalg.norm(trial.ned_m - before)), 0
    trial.mode("POSHOLD")
    trial.fly(8)
    yield "POSHOLD: position over 30 s [m]", spread(trial.fly(30), slice(0, 3)), 0.3
    trial.mode("GUIDED")
    target = np.add(trial.ned_m, (3.0, 2.0, 0.5))
    trial.send(
        dialect.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, dialect.MAV_FRAME_LOCAL_NED, 0b110111111000, *target, *[0.0] * 8
        )
    )
    trial.fly(40)
    yield "GUIDED: distance to the target [m]", float(np.linalg.norm(trial.ned_m - target)), 0.5
    corners = [np.add(target, step) for step in ((2, 0, 0), (2, 2, 0.5), (0, 2, 0))]
    trial.upload(corners)
    trial.mode("AUTO")
    trial.fly(120, lambda: len(corners) in trial.reached)
    yield "AUTO: waypoints not reached", float(len({1, 2, 3} - trial.reached)), 0
    yield "AUTO: distance to the last waypoint [m]", float(np.linalg.norm(trial.ned_m - corners[-1])), 1.5
    trial.mode("SURFTRAK")
    trial.fly(5)
    height = trial.sim.rov.telemetry().distance_to_seabed_m
    trial.steer(x=200)
    heights = []
    for _ in range(40):
        trial.fly(0.5)
        heights.append(trial.sim.rov.telemetry().distance_to_seabed_m)
    trial.steer()
    yield "SURFTRAK: height above the bed over 20 s [m]", max(abs(each - height) for each in heights), 0.5
    yield "largest EKF variance while armed", max(trial.variances), 0.8
    trial.set("SIM_PIN_MASK", 2)
    trial.fly(5)
    yield "leak not reported", float(not any("Leak" in text for text in trial.texts)), 0
    trial.set("SIM_PIN_MASK", 0)
    trial.mode("ALT_HOLD")
    trial.set("SIM_BATT_VOLTAGE", 9)
    trial.fly(20, lambda: not trial.armed)
    yield "armed with an empty battery", float(trial.armed), 0
    trial.set("SIM_BATT_VOLTAGE", 12.6)
    trial.fly(15)
    trial.set("BATT_FS_LOW_ACT", 0)
    trial.arm()
    trial.fly(2)
    yield "not armed again", float(not trial.armed), 0
    trial.has_station, trial.sticks = False, None
    trial.fly(8)
    yield "armed without a ground station", float(trial.armed), 0


def started() -> Simulator:
    """Return the simulator at the start of a flight."""
    sim = Simulator(prepared(load("lagoon")))
    sim.rov.place(START_M)
    return sim


def flown(binary: Path, defaults: list[Path], path: Path) -> Iterator[Row | str]:
    """Fly all modes, recorded; yield the measured values and then a digest of recorded messages and final state."""
    sim = started()
    with (
        Recorder(sim, path, topics=["odom", "imu"]),
        ArduSub(sim, port=0) as ardusub,
        Trial(ardusub) as trial,
        firmware_flying(ardusub, binary, station=trial.address, files=defaults, parameters=PARAMETERS),
    ):
        yield from flights(trial)
    digest = hashlib.blake2b(sim.save_state(), digest_size=8)
    for message in Recording(path).messages():
        digest.update(message.data)
    yield digest.hexdigest()


def speed(binary: Path, defaults: list[Path], seconds: float = 60.0) -> str:
    """Return how fast both programs run while the sonar pings at 10 Hz, and processor times per frame."""
    sim = started()
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, files=defaults, parameters=PARAMETERS) as it:
        firmware = psutil.Process(it.pid)
        sim.advance(5.0)
        began_s, theirs_s, steps_s, pings_s = time.monotonic(), sum(firmware.cpu_times()[:2]), 0.0, 0.0
        for _ in range(round(10 * seconds)):
            before_s = time.thread_time()
            sim.advance(0.1)
            between_s = time.thread_time()
            sim.rov.sonar.ping()
            steps_s, pings_s = steps_s + between_s - before_s, pings_s + time.thread_time() - between_s
        steps_us, pings_us, theirs_us = (
            1e6 * each / (400 * seconds) for each in (steps_s, pings_s, sum(firmware.cpu_times()[:2]) - theirs_s)
        )
        return (
            f"{seconds / (time.monotonic() - began_s):.1f} times real time with the sonar at 10 Hz; processor time of "
            f"a frame [us]: steps and exchange {steps_us:.1f}, pings {pings_us:.1f}, firmware {theirs_us:.1f}"
        )


def options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--binary", type=Path, required=True, help="ardusub, compiled for simulation (SITL)")
    parser.add_argument("--defaults", default="", help="its parameter files, such as sub-6dof.parm, with commas")
    parser.add_argument("--out", type=Path, help="folder for the two recordings")


def fly(given: argparse.Namespace) -> Iterator[tuple[str, bool, str]]:
    """Fly twice and measure the speed; yield whether each check passed, and what was measured."""
    if not given.binary.is_file():
        raise SystemExit(f"--binary '{given.binary}': no such file")
    binary, defaults = given.binary.resolve(), [Path(name) for name in given.defaults.split(",") if name]
    digests: list[str] = []
    with tempfile.TemporaryDirectory() as scratch:
        out = given.out or Path(scratch)
        out.mkdir(parents=True, exist_ok=True)
        for run in (1, 2):
            for row in flown(binary, defaults, out / f"{run}.mcap"):
                if isinstance(row, str):
                    digests.append(row)
                elif run == 1:
                    name, value, limit = row
                    yield name, value <= limit, f"{value:.4g} (at most {limit:g})"
        found = diff(*(Recording(out / f"{run}.mcap") for run in (1, 2)))
    differing = [f"/{each.topic}: {each.messages} messages differ, first at tick {each.tick}: {each.text}"
                 for each in found.partings]  # fmt: skip
    yield "the same bytes twice", digests[0] == digests[1], "; ".join([" ".join(digests), *differing, *found.notes])
    yield "speed", True, speed(binary, defaults)
