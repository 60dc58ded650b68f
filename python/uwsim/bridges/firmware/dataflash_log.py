"""A dataflash log of ArduSub (.bin) beside the model: its servo outputs drive the simulated vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.bridges.ardusub.servo_frames import thrusters_of
from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU
from uwsim.recording.real_flights.dataflash import MAGIC, pass_messages
from uwsim.recording.real_flights.frames import frame_of
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated
from uwsim.simulator.lockstep import FRAME_BYTES
from uwsim.simulator.simulator import Simulator

Array = NDArray[np.float64]
SAMPLE_S, LEAST_S, MOST_S, DEPTH_M = 0.1, 5.0, 86400.0, 50.0
OUTPUTS = 14  # of the message RCOU
QUANTITIES: Mapping[str, str] = {
    "speed ahead": "m/s", "speed to the right": "m/s", "speed down": "m/s", "roll": "deg", "pitch": "deg",
    "rate of yaw": "deg/s",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class ServoLog:
    """A flight, sampled every 0.1 s.

    outputs_us (n, 32): pulse widths; depth_m (n,); attitude_rad (n, 3): roll, pitch, yaw; velocity_ned_m_s (n, 3) and
    rates_rad_s (n, 3), body axes forward-right-down: as the firmware estimated and measured them.
    """

    times_s: Array
    outputs_us: NDArray[np.uint16] = field(repr=False)
    depth_m: Array = field(repr=False)
    attitude_rad: Array = field(repr=False)
    velocity_ned_m_s: Array = field(repr=False)
    rates_rad_s: Array = field(repr=False)


@dataclass(frozen=True, eq=False)
class Compared:
    """Motion by QUANTITIES at the same times, (n,): logged, and by the model, which starts from the log at each window.

    starts: indices at which windows begin.
    """

    times_s: Array
    logged: Mapping[str, Array]
    modelled: Mapping[str, Array]
    starts: NDArray[np.intp]


def read_servo_log(path: Path) -> ServoLog:
    """Read a log while its vehicle was armed. Raises OSError, or ValueError for a log that lacks something."""
    fields = {"RCOU": [f"C{n}" for n in range(1, OUTPUTS + 1)], "ATT": ["Roll", "Pitch", "Yaw"],
              "IMU": ["GyrX", "GyrY", "GyrZ"], "XKF1": ["VN", "VE", "VD", "PD"], "ARM": ["ArmState"]}  # fmt: skip
    rows: dict[str, list[list[float]]] = {name: [] for name in fields}
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            rule = "must be a dataflash log (.bin); two programs or parameter files are compared in pairs"
            raise ValueError(f"{path}: {rule}")

    def take(message: Any) -> None:
        name = message.get_type()
        if getattr(message, "I", 0) == 0 and getattr(message, "C", 0) == 0:  # the first IMU and core
            rows[name].append([1e-6 * message.TimeUS, *(getattr(message, each, 0) for each in fields[name])])

    pass_messages(path, fields, take)
    lacking = [name for name in fields if not rows[name]]
    if lacking:
        raise ValueError(f"{path}: has no {', '.join(lacking)}: must be a dataflash log of an armed ArduSub with EKF3")
    tables = {name: np.array(table) for name, table in rows.items()}
    armed = tables["ARM"]
    if not armed[:, 1].any():
        raise ValueError(f"{path}: was never armed: must be a log of a flight")
    on_s = armed[np.argmax(armed[:, 1] > 0), 0]
    off = armed[(armed[:, 1] == 0) & (armed[:, 0] > on_s), 0]
    ends_s = [table[-1, 0] for name, table in tables.items() if name != "ARM"]
    begin_s, end_s = max([on_s, *(table[0, 0] for name, table in tables.items() if name != "ARM")]), min(ends_s)
    end_s = min([end_s, *off[:1]])
    if not LEAST_S <= (armed_s := max(end_s - begin_s, 0.0)) <= MOST_S:  # a damaged log's times may leap
        raise ValueError(f"{path}: was armed for {armed_s:.6g} s: must be {LEAST_S:g} to {MOST_S:g} s")
    times_s = np.arange(begin_s, end_s, SAMPLE_S)

    def at(name: str, columns: slice) -> Array:
        table = tables[name]
        return np.column_stack([np.interp(times_s, table[:, 0], each) for each in table[:, 1:][:, columns].T])

    held = np.searchsorted(tables["RCOU"][:, 0], times_s, side="right") - 1
    outputs = np.zeros((len(times_s), FRAME_BYTES // 2), np.uint16)
    outputs[:, :OUTPUTS] = tables["RCOU"][held, 1:]
    tables["ATT"][:, 3] = np.degrees(np.unwrap(np.radians(tables["ATT"][:, 3])))
    filtered = at("XKF1", slice(0, 4))
    attitude = np.radians(at("ATT", slice(0, 3)))
    return ServoLog(times_s, outputs, filtered[:, 3], attitude, filtered[:, :3], at("IMU", slice(0, 3)))


def compared(log: ServoLog, scenario: Scenario, window_s: float) -> Compared:
    """Drive the first vehicle of a prepared scenario with a log's outputs, from the log's motion in each window."""
    sim = Simulator(open_water(scenario), threads=1)
    frame = frame_of(thrusters_of(sim, sim.rov.name), sim.rov.name)
    steps, length = round(SAMPLE_S / sim.step_s), max(round(window_s / SAMPLE_S), 2)
    starts = np.arange(0, len(log.times_s) - 1, length)
    rows = []
    for start in starts.tolist():
        place_as_logged(sim, log, start)
        rows.append(_motion_of(sim))
        for k in range(start, min(start + length, len(log.times_s)) - 1):
            frames = log.outputs_us[k].astype("<u2").tobytes() * steps
            sim.lockstep.play(sim, vehicle=sim.rov.name, frame=frame, from_tick=sim.tick, frames=frames)
            sim.step(steps)
            rows.append(_motion_of(sim))
    count = len(rows)
    modelled = np.array(rows)
    logged = _logged(log)[:count]
    names = list(QUANTITIES)
    return Compared(
        log.times_s[:count],
        {name: logged[:, k] for k, name in enumerate(names)},
        {name: modelled[:, k] for k, name in enumerate(names)},
        starts,
    )


def open_water(scenario: Scenario) -> Scenario:
    """Return a variant without waves, currents, obstacles and a bed nearby, since the place of a log is not known."""
    data = scenario.given()
    water = {key: value for key, value in scenario.water.given().items() if key not in ("surface", "current")}
    entry = {**scenario.vehicles[0].given(), "start": {"position_m": [0, 0, -DEPTH_M]}}
    bed = {"source": "noise", "size_m": [80, 80], "spacing_m": 4, "bed_depth_m": 2 * DEPTH_M}
    kept = {key: data[key] for key in ("name", "step_s", "dynamics") if key in data}
    return validated(Scenario, {**kept, "water": {**water, "current_world_m_s": (0, 0, 0)}, "terrain": bed,
                                "vehicles": [entry]})  # fmt: skip


def place_as_logged(sim: Simulator, log: ServoLog, k: int) -> None:
    """Place the vehicle with a row's attitude, velocity and rates."""
    ned_from_frd = Rotation.from_euler("ZYX", log.attitude_rad[k][::-1])
    enu_from_flu = Rotation.from_matrix(NED_FROM_ENU.T @ ned_from_frd.as_matrix() * FRD)
    body = FRD * ned_from_frd.inv().apply(log.velocity_ned_m_s[k])
    motion = np.concatenate([body, FRD * log.rates_rad_s[k]])
    sim.rov.place((0.0, 0.0, -DEPTH_M), enu_from_flu.as_quat(), motion)


def _motion_of(sim: Simulator) -> list[float]:
    """Return the simulated motion by QUANTITIES."""
    velocity = sim.rov.velocity
    ned_from_frd = NED_FROM_ENU @ sim.rov.pose.world_from_body[:3, :3] * FRD
    down = ned_from_frd @ (FRD * velocity.linear_body_m_s)
    _, pitch, roll = Rotation.from_matrix(ned_from_frd).as_euler("ZYX", degrees=True)
    ahead, left, _ = velocity.linear_body_m_s
    return [ahead, -left, down[2], roll, pitch, -np.degrees(velocity.angular_body_rad_s[2])]


def _logged(log: ServoLog) -> Array:
    """Return the logged motion by QUANTITIES, (n, 6)."""
    turns = Rotation.from_euler("ZYX", log.attitude_rad[:, ::-1])
    body = turns.inv().apply(log.velocity_ned_m_s)
    return np.column_stack(
        [body[:, 0], body[:, 1], log.velocity_ned_m_s[:, 2], *np.degrees(log.attitude_rad[:, :2].T),
         np.degrees(log.rates_rad_s[:, 2])]
    )  # fmt: skip
