"""The messages in which a MAVLink vehicle reports its state, from one reading of the simulator."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU, Home, Vector, euler_rad
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

RATE_HZ = 10.0
UNKNOWN_U16, UNKNOWN_I16 = 0xFFFF, 0x7FFF
SENSORS = {"imu": 0x1 | 0x2, "compass": 0x4, "pressure": 0x8, "depth": 0x8, "altitude": 0x100}
"""MAV_SYS_STATUS_SENSOR by kind: gyroscope and accelerometer, magnetometer, absolute pressure, range finder."""
HPA_PER_PA = 0.01


class State(NamedTuple):
    """One reading. position_world_m: by the estimate unless the truth is published. velocity_body: (6,)."""

    time_s: float
    position_world_m: Vector
    world_from_body: Vector
    velocity_body: Vector
    pressure_pa: float
    temperature_deg_c: float
    altitude_m: float
    battery_percent: float
    throttle_percent: int
    holds: tuple[str, ...]
    released: bool
    all_stopped: bool
    failsafe: str
    hold_note: str
    events: int
    sensors: int
    tilt_rad: float


def read(sim: Simulator, source: Source, *, truth: bool) -> State:
    """Return the present state, on the simulator's thread."""
    vehicle = source.of(sim)
    mover = vehicle if truth else vehicle.estimate
    pose, velocity = mover.pose, mover.velocity
    panel, holds = vehicle.telemetry(), vehicle.gate.holds
    failsafe = vehicle.failsafe
    by_kind = {sensor.kind: sensor for sensor in reversed(vehicle.sensors.values())}
    return State(
        time_s=sim.time_s,
        position_world_m=np.asarray(pose.position_world_m),
        world_from_body=np.asarray(pose.world_from_body),
        velocity_body=np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s]),
        pressure_pa=_reading(by_kind, "pressure", panel.pressure_pa),
        temperature_deg_c=_reading(by_kind, "temperature", panel.temperature_deg_c),
        altitude_m=_reading(by_kind, "altitude", math.nan),
        battery_percent=panel.battery_percent,
        throttle_percent=round(100 * max((abs(effort) for effort in vehicle.effort), default=0.0)),
        holds=() if holds is None else tuple(name for name, target in holds.targets.items() if target is not None),
        released=vehicle.released,
        all_stopped=vehicle.all_stopped,
        failsafe="" if failsafe is None or not failsafe.has_control else f"{failsafe.state}: {failsafe.cause}",
        hold_note="" if holds is None else holds.note,
        events=len(sim.events),
        sensors=_present(vehicle),
        tilt_rad=vehicle.sonar.elevation_rad if vehicle.sonars else math.nan,
    )


def _reading(sensors: dict[str, Any], kind: str, otherwise: float) -> float:
    return float(sensors[kind].read()) if kind in sensors else otherwise


def _present(vehicle: Vehicle) -> int:
    bits = 0
    for sensor in vehicle.sensors.values():
        bits |= SENSORS.get(sensor.kind, 0)
    return bits


def messages(mav: Any, state: State, home: Home) -> Iterator[Any]:
    """Yield the messages of one reading. mav: pymavlink's dialect, a MAVLink object."""
    ms = round(1e3 * state.time_s) % 2**32
    roll, pitch, yaw = euler_rad(state.world_from_body)
    rates = state.velocity_body[3:] * FRD
    velocity = NED_FROM_ENU @ (state.world_from_body[:3, :3] @ state.velocity_body[:3])
    position = NED_FROM_ENU @ state.position_world_m
    lat_deg, lon_deg = home.degrees(state.position_world_m)
    up_mm = round(1e3 * state.position_world_m[2])
    heading_cdeg = round(100 * math.degrees(yaw)) % 36000
    yield mav.attitude_encode(ms, roll, pitch, yaw, *rates)
    yield mav.local_position_ned_encode(ms, *position, *velocity)
    yield mav.global_position_int_encode(
        ms, round(1e7 * lat_deg), round(1e7 * lon_deg), up_mm, up_mm, *(_int16(100 * part) for part in velocity),
        heading_cdeg,
    )  # fmt: skip
    temperature_cdeg = _int16(100 * state.temperature_deg_c)
    yield mav.scaled_pressure2_encode(ms, HPA_PER_PA * state.pressure_pa, 0.0, temperature_cdeg)
    speed = float(np.hypot(velocity[0], velocity[1]))
    yield mav.vfr_hud_encode(speed, speed, heading_cdeg // 100, state.throttle_percent, -position[2], -velocity[2])
    percent = -1 if math.isnan(state.battery_percent) else min(max(round(state.battery_percent), 0), 100)
    yield mav.sys_status_encode(
        state.sensors, state.sensors, state.sensors, 0, UNKNOWN_U16, -1, percent, 0, 0, 0, 0, 0, 0
    )
    cells = [UNKNOWN_U16] * 10
    yield mav.battery_status_encode(0, 0, 0, UNKNOWN_I16, cells, -1, -1, -1, percent)
    if math.isfinite(state.altitude_m):
        yield mav.rangefinder_encode(state.altitude_m, 0.0)
    if math.isfinite(state.tilt_rad):
        yield mav.named_value_float_encode(ms, b"SonarTilt", state.tilt_rad)


def _int16(value: float) -> int:
    return min(max(round(value), -0x7FFF), 0x7FFF) if math.isfinite(value) else UNKNOWN_I16
