"""Fly a compiled ArduSub in lockstep through its modes; see tools/ardusub-trial.

A single thread makes the steps and sends MAVLink messages while the firmware waits for a line, so that each message
arrives at the same frame in each run. ArduSub gets its position from the vehicle's own navigation (IMU, compass, DVL,
depth) as ODOMETRY, at 10 Hz.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as dialect

from uwsim import Simulator
from uwsim.bridges.ardusub import ArduSub, prepared
from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU, Home
from uwsim.recording import Recorder
from uwsim.recording.diff import diff
from uwsim.recording.reader import Recording
from uwsim.scenario import load

HOME = Home(33.81, -118.39)
START_M = (-15.0, -16.0, -1.0)
PARAMETERS = """LOG_BACKEND_TYPE 0
GPS1_TYPE 0
VISO_TYPE 1
EK3_SRC1_POSXY 6
EK3_SRC1_VELXY 6
EK3_SRC1_POSZ 1
EK3_SRC1_VELZ 0
EK3_SRC1_YAW 1
RNGFND1_TYPE 100
RNGFND1_ORIENT 25
RNGFND1_MIN 0.1
RNGFND1_MAX 50
FS_GCS_ENABLE 2
BATT_LOW_VOLT 10
BATT_FS_LOW_ACT 2
LEAK1_TYPE 1
LEAK1_PIN 1
LEAK1_LOGIC 0
FS_LEAK_ENABLE 1
"""
MODES = {"STABILIZE": 0, "ALT_HOLD": 2, "AUTO": 3, "GUIDED": 4, "POSHOLD": 16, "MANUAL": 19, "SURFTRAK": 21}
CHUNK = 20  # frames between two exchanges of MAVLink messages: 0.05 s
NEUTRAL = {"x": 0, "y": 0, "z": 500, "r": 0}


class Trial:
    """A flight in progress. texts: all status texts. armed, reached: as reported by the firmware's messages."""

    def __init__(self, sim: Simulator, autopilot: ArduSub, link: Any) -> None:
        self.sim, self.autopilot, self.link = sim, autopilot, link
        self.texts: list[str] = []
        self.messages: dict[str, Any] = {}
        self.reached: set[int] = set()
        self.variances: list[float] = []
        self.sticks: dict[str, int] | None = None
        self.has_station = True
        self._asked: list[Any] = []

    @property
    def armed(self) -> bool:
        """True if the firmware reports that it is armed."""
        return bool(self.messages["HEARTBEAT"].base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)

    @property
    def ned_m(self) -> Any:
        """The true position, north, east, down."""
        return NED_FROM_ENU @ self.sim.rov.pose.position_world_m

    def fly(self, seconds: float, until: Callable[[], bool] = lambda: False) -> list[Any]:
        """Fly for a time, or until a condition is true; return the true positions every 0.05 s, (n, 3)."""
        track = []
        for _ in range(round(seconds * 400 / CHUNK)):
            if until():
                break
            self.autopilot.wait()
            self._receive()
            self._send()
            self.sim.step(CHUNK)
            track.append(self.ned_m)
        return track

    def _receive(self) -> None:
        while (message := self.link.recv_match(blocking=False)) is not None:
            kind = message.get_type()
            if kind == "STATUSTEXT":
                self.texts.append(message.text)
            elif kind == "MISSION_ITEM_REACHED":
                self.reached.add(message.seq)
            elif kind == "MISSION_REQUEST" and message.seq < len(self._asked):
                self.link.mav.send(self._asked[message.seq])
            elif kind == "EKF_STATUS_REPORT" and self.armed:
                self.variances.append(
                    max(message.velocity_variance, message.pos_horiz_variance, message.compass_variance)
                )
            self.messages[kind] = message

    def _send(self) -> None:
        tick, mav = self.sim.tick, self.link.mav
        if self.has_station and tick % 400 == 0:
            mav.heartbeat_send(dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        if self.sticks is not None and tick % 40 == 0:
            mav.manual_control_send(1, **self.sticks, buttons=0)
        if tick % 40 == 0 and tick > 2400:
            self._send_odometry()

    def _send_odometry(self) -> None:
        estimate = self.sim.rov.estimate
        world_from_body = estimate.pose.world_from_body
        r = NED_FROM_ENU @ world_from_body[:3, :3] * FRD
        w = np.sqrt(max(1 + np.trace(r), 1e-9)) / 2
        q = [w, (r[2, 1] - r[1, 2]) / 4 / w, (r[0, 2] - r[2, 0]) / 4 / w, (r[1, 0] - r[0, 1]) / 4 / w]
        velocity = estimate.velocity
        self.link.mav.odometry_send(
            self.sim.time_ns // 1000, dialect.MAV_FRAME_LOCAL_FRD, dialect.MAV_FRAME_BODY_FRD,
            *(NED_FROM_ENU @ estimate.pose.position_world_m), q, *(velocity.linear_body_m_s * FRD),
            *(velocity.angular_body_rad_s * FRD), [float("nan")] * 21, [float("nan")] * 21, 0, 0, 100,
        )  # fmt: skip

    def command(self, command: int, *values: float) -> None:
        """Send a command; the next `fly` delivers its effect."""
        self.autopilot.wait()
        self.link.mav.command_long_send(1, 1, command, 0, *values, *[0.0] * (7 - len(values)))

    def mode(self, name: str) -> None:
        """Request a mode, and wait until the firmware has changed to it."""
        self.command(dialect.MAV_CMD_DO_SET_MODE, 1, MODES[name])
        self.fly(5, lambda: self.messages["HEARTBEAT"].custom_mode == MODES[name])

    def arm(self, *, on: bool = True) -> None:
        """Arm or disarm, and wait until the firmware has done so."""
        self.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, float(on))
        self.fly(5, lambda: self.armed == on)

    def set(self, name: str, value: float) -> None:
        """Set a parameter."""
        self.autopilot.wait()
        self.link.mav.param_set_send(1, 1, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32)
        self.fly(0.5)

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
        self.autopilot.wait()
        self.link.mav.mission_count_send(1, 1, len(self._asked))
        self.fly(5, lambda: "MISSION_ACK" in self.messages)


def spread(track: list[Any], axes: slice | int) -> float:
    """Return the largest distance of a track's positions from their mean [m]."""
    points = np.array(track)[:, axes].reshape(len(track), -1)
    return float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())


Row = tuple[str, float, float]
"""Name of a check, measured value, largest value that passes."""


def flights(trial: Trial) -> Iterator[Row]:
    """Fly in each mode; yield the measured values."""
    trial.fly(8)
    trial.autopilot.wait()
    trial.link.mav.set_gps_global_origin_send(1, round(1e7 * HOME.lat_deg), round(1e7 * HOME.lon_deg), 0)
    trial.sticks = dict(NEUTRAL)
    trial.fly(22)
    trial.arm()
    yield "not armed", float(not trial.armed), 0
    trial.mode("ALT_HOLD")
    trial.sticks["z"] = 200
    trial.fly(60, lambda: trial.ned_m[2] > 3.5)
    trial.sticks["z"] = 500
    trial.fly(5)
    yield "ALT_HOLD: depth over 20 s [m]", spread(trial.fly(20), 2), 0.1
    trial.mode("STABILIZE")
    yaw = trial.sim.rov.pose.yaw_rad
    trial.sticks["x"] = 300
    trial.fly(5)
    trial.sticks["x"] = 0
    trial.fly(5)
    yield "STABILIZE: heading while flying ahead [rad]", abs(trial.sim.rov.pose.yaw_rad - yaw), 0.1
    trial.mode("MANUAL")
    before = trial.ned_m
    trial.sticks["y"] = 500
    trial.fly(4)
    trial.sticks["y"] = 0
    yield "MANUAL: 0.3 m less the way by the lateral stick [m]", 0.3 - float(np.linalg.norm(trial.ned_m - before)), 0
    trial.mode("POSHOLD")
    trial.fly(8)
    yield "POSHOLD: position over 30 s [m]", spread(trial.fly(30), slice(0, 3)), 0.3
    trial.mode("GUIDED")
    target = np.add(trial.ned_m, (3.0, 2.0, 0.5))
    trial.autopilot.wait()
    trial.link.mav.set_position_target_local_ned_send(
        0, 1, 1, dialect.MAV_FRAME_LOCAL_NED, 0b110111111000, *target, *[0.0] * 8
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
    trial.sticks["x"] = 200
    heights = [trial.fly(0.5) and trial.sim.rov.telemetry().distance_to_seabed_m for _ in range(40)]
    trial.sticks["x"] = 0
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


@contextmanager
def firmware(binary: Path, defaults: str) -> Iterator[int]:
    """Run the firmware in a new folder; yield its process id."""
    with tempfile.TemporaryDirectory(prefix="ardusub-") as folder:
        own = Path(folder) / "trial.parm"
        own.write_text(PARAMETERS)
        files = ",".join([*filter(None, defaults.split(",")), str(own)])
        place = f"{HOME.lat_deg},{HOME.lon_deg},0,0"
        command = [str(binary), "--model", "JSON:127.0.0.1", "--speedup", "1", "--rate", "400", "--home", place,
                   "--start-time", "1600000000", "--defaults", files, "-I0"]  # fmt: skip
        with subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                yield process.pid
            finally:
                process.kill()


def connected() -> Any:
    """Return the MAVLink connection to the firmware, for which the firmware waits."""
    for _ in range(100):
        try:
            return mavutil.mavlink_connection("tcp:127.0.0.1:5760", source_system=255, dialect="ardupilotmega")
        except OSError:
            time.sleep(0.1)
    raise TimeoutError("ArduSub does not listen on TCP 5760")


def started() -> Simulator:
    """Return the simulator at the start of a flight."""
    sim = Simulator(prepared(load("lagoon")))
    sim.rov.place(START_M)
    return sim


def flown(binary: Path, defaults: str, path: Path, print_row: Callable[[Row], None]) -> str:
    """Fly all modes, recorded; return a digest of the recorded messages and the final state."""
    sim = started()
    with Recorder(sim, path, topics=["odom", "imu"]), ArduSub(sim) as autopilot, firmware(binary, defaults):
        for row in flights(Trial(sim, autopilot, connected())):
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


def speed(binary: Path, defaults: str, seconds: float = 60.0) -> Speed:
    """Return how fast both programs run while the sonar pings at 10 Hz."""
    sim = started()
    with ArduSub(sim) as autopilot, firmware(binary, defaults) as process:
        link = connected()
        autopilot.wait()
        sim.advance(5.0)
        began_s, theirs_s, steps_s, pings_s = time.monotonic(), processor_s(process), 0.0, 0.0
        for _ in range(round(10 * seconds)):
            before_s = time.thread_time()
            sim.advance(0.1)
            between_s = time.thread_time()
            sim.rov.sonar.ping()
            steps_s, pings_s = steps_s + between_s - before_s, pings_s + time.thread_time() - between_s
            link.recv_match(blocking=False)  # the firmware waits if its telemetry is not read
        theirs_s = processor_s(process) - theirs_s
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
    defaults = ",".join(str(Path(name).resolve()) for name in given.defaults.split(",") if name)
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
