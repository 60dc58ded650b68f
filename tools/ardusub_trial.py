"""Fly a compiled ArduSub in lockstep through its modes; see tools/ardusub-trial.

A single thread makes the steps and sends MAVLink messages while the firmware waits for a line, so that each message
arrives at the same frame in each run. ArduSub gets its position from the vehicle's own navigation (IMU, compass, DVL,
depth) as ODOMETRY; see uwsim.bridges.firmware_flight.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as dialect

from uwsim import Simulator
from uwsim.bridges.ardusub import ArduSub, prepared
from uwsim.bridges.firmware_flight import firmware_flying
from uwsim.bridges.firmware_pilot import FirmwarePilot
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


def flown(binary: Path, defaults: list[Path], path: Path, print_row: Callable[[Row], None]) -> str:
    """Fly all modes, recorded; return a digest of the recorded messages and the final state."""
    sim = started()
    with (
        Recorder(sim, path, topics=["odom", "imu"]),
        ArduSub(sim, port=0) as ardusub,
        Trial(ardusub) as trial,
        firmware_flying(ardusub, binary, station=trial.address, files=defaults, parameters=PARAMETERS),
    ):
        for row in flights(trial):
            print_row(row)
    digest = hashlib.blake2b(sim.save_state(), digest_size=8)
    for message in Recording(path).messages():
        digest.update(message.data)
    return digest.hexdigest()


def differences(first: Path, second: Path) -> list[str]:
    """Return a line for each channel whose messages differ between two recordings, and for each other difference."""
    one, other = Recording(first), Recording(second)
    found = diff(one, other)
    lines = [f"/{each.topic}: {each.messages} messages differ, first at tick {each.tick}: {each.text}"
             for each in found.partings]  # fmt: skip
    states = {recording.end.state if recording.end else "" for recording in (one, other)}
    return [*lines, *found.notes, *(["the states at the end differ"] if len(states) > 1 else [])]


class Speed(NamedTuple):
    """Simulated seconds per second; processor time per frame [us] of this thread's steps, pings and the firmware."""

    factor: float
    steps_us: float
    pings_us: float
    firmware_us: float


def processor_s(process: int) -> float:
    """Return the processor time that a process has used."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def speed(binary: Path, defaults: list[Path], seconds: float = 60.0) -> Speed:
    """Return how fast both programs run while the sonar pings at 10 Hz."""
    sim = started()
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, files=defaults, parameters=PARAMETERS) as it:
        sim.advance(5.0)
        began_s, theirs_s, steps_s, pings_s = time.monotonic(), processor_s(it.pid), 0.0, 0.0
        for _ in range(round(10 * seconds)):
            before_s = time.thread_time()
            sim.advance(0.1)
            between_s = time.thread_time()
            sim.rov.sonar.ping()
            steps_s, pings_s = steps_s + between_s - before_s, pings_s + time.thread_time() - between_s
        theirs_s = processor_s(it.pid) - theirs_s
        costs = (1e6 * each / (400 * seconds) for each in (steps_s, pings_s, theirs_s))
        return Speed(seconds / (time.monotonic() - began_s), *costs)


def main() -> int:
    """Fly twice and measure the speed. Return 1 if a check fails."""
    parser = argparse.ArgumentParser(description="Fly a compiled ArduSub through its modes.")
    parser.add_argument("--binary", type=Path, required=True, help="ardusub, compiled for simulation (SITL)")
    parser.add_argument("--defaults", default="", help="its parameter files, such as sub-6dof.parm, with commas")
    parser.add_argument("--out", type=Path, help="folder for the two recordings")
    given = parser.parse_args()
    if not given.binary.is_file():
        parser.error(f"--binary '{given.binary}': no such file")
    defaults = [Path(name) for name in given.defaults.split(",") if name]
    failed: list[str] = []

    def print_row(row: Row) -> None:
        name, value, limit = row
        is_ok = value <= limit
        print(f"{'ok  ' if is_ok else 'FAIL'} {name}: {value:.4g} (at most {limit:g})", flush=True)
        failed.extend([] if is_ok else [name])

    with tempfile.TemporaryDirectory() as scratch:
        out = given.out or Path(scratch)
        out.mkdir(parents=True, exist_ok=True)
        binary = given.binary.resolve()
        digests = [
            flown(binary, defaults, out / f"{run}.mcap", print_row if run == 1 else lambda row: None) for run in (1, 2)
        ]
        differing = differences(out / "1.mcap", out / "2.mcap")
    print(f"digests of two flights: {' '.join(digests)}")
    for line in differing:
        print(f"     {line}")
    failed.extend([] if digests[0] == digests[1] else ["the same bytes twice"])
    found = speed(binary, defaults)
    print(f"{found.factor:.1f} times real time with the sonar at 10 Hz")
    print(f"processor time of a frame [us]: steps and exchange {found.steps_us:.1f}, "
          f"pings {found.pings_us:.1f}, firmware {found.firmware_us:.1f}")  # fmt: skip
    print(f"failed: {', '.join(failed)}" if failed else "all passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
