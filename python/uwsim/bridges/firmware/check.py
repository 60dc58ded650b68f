"""Two firmwares, or two sets of parameters, through the same flight in the same sea, for several seeds."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.ardusub.ardusub import ArduSub, prepared
from uwsim.bridges.firmware.firmware import FirmwareError, checked_program, end_with_parent
from uwsim.bridges.firmware.flight import firmware_flying
from uwsim.bridges.firmware.pilot import CHUNK, RATE_HZ, FirmwarePilot
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.read.validated import validated
from uwsim.simulator.simulator import Simulator

BATTERY = "bluerov2_18ah"
START_M, DIVE_M = 1.0, 3.5
HOLD_S, SETTLE_S, AHEAD_S = 20.0, 8.0, 10.0
STEP_S = CHUNK / RATE_HZ
UNITS: Mapping[str, str] = {
    "depth, rms in ALT_HOLD": "m",
    "depth, largest in ALT_HOLD": "m",
    "power in ALT_HOLD": "W",
    "speed ahead in STABILIZE": "m/s",
    "heading, largest in STABILIZE": "deg",
    "position, rms in POSHOLD": "m",
    "power in POSHOLD": "W",
    "energy": "Wh",
    "EKF, largest variance": "",
    "EKF, error of position": "m",
}
"""The values of a flight. Holds are about their mean; the EKF's error is that of its motion while in POSHOLD."""


class Side(NamedTuple):
    """A firmware and its parameter files."""

    name: str
    binary: Path
    files: tuple[Path, ...]


@dataclass(frozen=True)
class Flown:
    """One flight. values: by UNITS; NaN where not known. times_s, depths_m: (n,), every 0.05 s."""

    side: str
    seed: int
    values: Mapping[str, float]
    times_s: NDArray[np.float64] = field(repr=False)
    depths_m: NDArray[np.float64] = field(repr=False)


def sides_of(first: Path, second: Path, binary: Path | None) -> tuple[Side, Side]:
    """Return what is compared: two programs, or two parameter files of one program. Raises FirmwareError."""
    paths = (first, second)
    for path in paths:
        if not path.is_file():
            raise FirmwareError(f"{path}: no such file")
    if first.samefile(second):
        raise FirmwareError(f"{first}: is given twice: must be compared with another")
    are_programs = [os.access(path, os.X_OK) for path in paths]
    if are_programs[0] != are_programs[1]:
        raise FirmwareError(f"{first}, {second}: one is a program, the other is not: must be of the same kind")
    names = [path.name for path in paths] if first.name != second.name else [str(path) for path in paths]
    if are_programs[0]:
        if binary is not None:
            raise FirmwareError(f"--binary {binary}: cannot be given with two programs")
        return Side(names[0], checked_program(first), ()), Side(names[1], checked_program(second), ())
    if binary is None:
        raise FirmwareError(f"{first}, {second}: two parameter files need --binary, the program that reads them")
    program = checked_program(binary)
    return Side(names[0], program, (first.resolve(),)), Side(names[1], program, (second.resolve(),))


def with_battery(scenario: Scenario) -> Scenario:
    """Return a variant whose first vehicle has a battery, from which energy is known, if its thrusters allow one."""
    data = scenario.given()
    entries = [entry.given() for entry in scenario.vehicles]
    if scenario.vehicles[0].battery is not None:
        return scenario
    try:
        return validated(Scenario, {**data, "vehicles": [{**entries[0], "battery": BATTERY}, *entries[1:]]})
    except ScenarioError:
        return scenario


def checked(
    sides: Sequence[Side], scenario: str | Path, vehicle: str | Path, seeds: Sequence[int], workers: int
) -> Iterator[Flown]:
    """Fly each side with each seed, in parallel; yield the flights as they end. Raises FirmwareError, ScenarioError."""
    world = with_battery(prepared(load(scenario), vehicle))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, _begin_worker, (os.getpid(),)) as pool:
        jobs = [pool.submit(flight, side, world, seed) for seed in seeds for side in sides]
        try:
            for job in as_completed(jobs):
                yield job.result()
        except BrokenProcessPool:
            raise FirmwareError("a process that flew has died: is there enough memory? --workers limits them") from None
        finally:
            pool.shutdown(cancel_futures=True)


def _begin_worker(parent: int) -> None:
    """End with the parent, which Ctrl-C ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)


def flight(side: Side, scenario: Scenario, seed: int) -> Flown:
    """Fly once, with the sensors' errors: dive, hold the depth, go ahead, hold the position. Raises FirmwareError."""
    sim = Simulator(scenario, seed=seed, threads=1)
    x_m, y_m, _ = sim.rov.pose.position_world_m
    with (
        ArduSub(sim, port=0, with_noise=True) as ardusub,
        FirmwarePilot(ardusub) as pilot,
        firmware_flying(ardusub, side.binary, station=pilot.address, files=side.files),
    ):
        sim.rov.place((float(x_m), float(y_m), -START_M))
        meter = _Meter(pilot)
        pilot.each = meter.note
        values = dict(_flown(pilot, meter))
    return Flown(side.name, seed, values, np.array(meter.times_s), np.array(meter.depths_m))


def _flown(pilot: FirmwarePilot, meter: _Meter) -> Iterator[tuple[str, float]]:
    pilot.get_ready()
    pilot.arm()
    pilot.mode("ALT_HOLD")
    pilot.steer(z=200)
    pilot.fly(60, lambda: pilot.ned_m[2] > DIVE_M)
    pilot.steer()
    pilot.fly(SETTLE_S)
    used_j, depths_m = meter.used_j, np.array(pilot.fly(HOLD_S))[:, 2]
    off_m = np.abs(depths_m - depths_m.mean())
    yield "depth, rms in ALT_HOLD", float(np.std(depths_m))
    yield "depth, largest in ALT_HOLD", float(off_m.max())
    yield "power in ALT_HOLD", (meter.used_j - used_j) / HOLD_S
    pilot.mode("STABILIZE")
    yaw_rad, yaws_rad = pilot.ardusub.flown.pose.yaw_rad, []
    pilot.steer(x=500)
    for _ in range(round(AHEAD_S)):
        pilot.fly(1)
        yaws_rad.append(pilot.ardusub.flown.pose.yaw_rad)
    yield "speed ahead in STABILIZE", float(np.linalg.norm(pilot.ardusub.flown.velocity.linear_body_m_s))
    turns = [abs(math.remainder(each - yaw_rad, math.tau)) for each in yaws_rad]
    yield "heading, largest in STABILIZE", math.degrees(max(turns))
    pilot.steer()
    pilot.mode("POSHOLD")
    pilot.fly(SETTLE_S)
    meter.errors_m.clear()
    used_j, places_m = meter.used_j, np.array(pilot.fly(HOLD_S))[:, :2]
    yield "position, rms in POSHOLD", float(np.sqrt(np.var(places_m, axis=0).sum()))
    yield "power in POSHOLD", (meter.used_j - used_j) / HOLD_S
    yield "energy", meter.used_j / 3600
    yield "EKF, largest variance", max(pilot.variances, default=math.nan)
    errors_m = np.array(meter.errors_m)
    yield "EKF, error of position", float(np.sqrt(np.mean(errors_m**2))) if len(errors_m) else math.nan


class _Meter:
    """Sums a flight's electrical energy, and compares the firmware's position with the true one."""

    def __init__(self, pilot: FirmwarePilot) -> None:
        self._pilot = pilot
        self.used_j = 0.0
        self.times_s: list[float] = []
        self.depths_m: list[float] = []
        self.errors_m: list[float] = []

    def note(self) -> None:
        """Add the last 0.05 s."""
        battery, at_m = self._pilot.ardusub.flown.battery, self._pilot.ned_m
        self.used_j += battery.voltage_v * battery.current_a * STEP_S
        self.times_s.append(self._pilot.sim.time_s)
        self.depths_m.append(float(at_m[2]))
        found = self._pilot.messages.get("LOCAL_POSITION_NED")
        if found is not None:
            self.errors_m.append(math.hypot(found.x - at_m[0], found.y - at_m[1]))
