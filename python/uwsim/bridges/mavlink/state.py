"""State: one reading of a vehicle, from which all telemetry is made."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from uwsim.bridges.mavlink.earth import Vector
from uwsim.channels.source import Source
from uwsim.simulator.helm import Source as Rank
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

SENSORS = {"imu": 0x1 | 0x2, "compass": 0x4, "pressure": 0x8, "depth": 0x8, "altitude": 0x100}
"""MAV_SYS_STATUS_SENSOR by kind: gyroscope and accelerometer, magnetometer, absolute pressure, range finder."""
POSITION, CONTROLS, MOTORS, AHRS, BATTERY, PREARM = 0x20, 0x7C00, 0x8000, 1 << 21, 1 << 25, 1 << 28
"""MAV_SYS_STATUS_SENSOR. POSITION: the GPS, in whose place an underwater vehicle's own position source is reported."""
LOST_M = 10.0
"""A standard deviation of the horizontal position above which the position counts as unknown."""


class State(NamedTuple):
    """One reading. position_world_m: estimated, unless the truth is published. velocity_body: (6,).

    gimbal_rad: pitch (positive up) and yaw (positive to the right) of the first camera with a motor. camera_tilt: that
    camera's pitch as a fraction of its range, from 0 (lowest) to 1. lights: the fraction of lamps that are on.
    thrusters: their commands. imu: specific force [m/s2] and angular velocity [rad/s] in body axes, (6,). variances: of
    velocity, horizontal position, height and heading [SI], 0 for the truth. sensors, healthy: MAV_SYS_STATUS_SENSOR.
    can_arm: whether arming would succeed. gps: sample of the first sensor of kind gps; None without one. Values that do
    not exist are NaN.
    """

    time_s: float
    position_world_m: Vector
    world_from_body: Vector
    velocity_body: Vector
    pressure_pa: float
    temperature_deg_c: float
    altitude_m: float
    battery_percent: float
    voltage_v: float
    current_a: float
    consumed_ah: float
    thrusters: tuple[float, ...]
    imu: Vector
    variances: tuple[float, float, float, float]
    throttle_percent: int
    holds: tuple[str, ...]
    released: bool
    all_stopped: bool
    failsafe: str
    hold_note: str
    events: int
    sensors: int
    healthy: int
    can_arm: bool
    tilt_rad: float
    gimbal_rad: tuple[float, float]
    camera_tilt: float
    lights: float
    gps: Any


def read(sim: Simulator, source: Source, *, truth: bool) -> State:
    """Return the current state. Must be called on the simulator's thread."""
    vehicle = source.of(sim)
    mover = vehicle if truth else vehicle.navigation.shown
    pose, velocity = mover.pose, mover.velocity
    panel, holds = vehicle.telemetry(), vehicle.holds
    failsafe = vehicle.failsafe
    gimbal_rad, camera_tilt = _gimbal_of(vehicle)
    lamps = [lamp.on for lamp in vehicle.lamps.values()]
    by_kind = {sensor.kind: sensor for sensor in reversed(vehicle.sensors.values())}
    variances = (0.0, 0.0, 0.0, 0.0) if truth else _variances(vehicle.navigation.shown.covariance)
    present, healthy = _sensor_bits(by_kind, is_placed=variances[1] < LOST_M**2, charge=panel.battery_percent)
    battery = vehicle.battery
    return State(
        time_s=sim.time_s,
        position_world_m=np.asarray(pose.position_world_m),
        world_from_body=np.asarray(pose.world_from_body),
        velocity_body=np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s]),
        pressure_pa=_reading(by_kind, "pressure", panel.pressure_pa),
        temperature_deg_c=_reading(by_kind, "temperature", panel.temperature_deg_c),
        altitude_m=_reading(by_kind, "altitude", math.nan),
        battery_percent=panel.battery_percent,
        voltage_v=battery.voltage_v,
        current_a=battery.current_a,
        consumed_ah=battery.capacity_ah - battery.charge_ah,
        thrusters=tuple(thruster.command for thruster in vehicle.thrusters.values()),
        imu=_imu(by_kind),
        variances=variances,
        throttle_percent=round(100 * max((abs(effort) for effort in vehicle.effort), default=0.0)),
        holds=() if holds is None else tuple(name for name, target in holds.targets.items() if target is not None),
        released=vehicle.released,
        all_stopped=vehicle.all_stopped,
        failsafe="" if failsafe is None or not failsafe.has_control else f"{failsafe.state}: {failsafe.cause}",
        hold_note="" if holds is None else holds.note,
        events=len(sim.events),
        sensors=present,
        healthy=healthy,
        can_arm=not vehicle.helm.refusal(Rank.FAILSAFE),
        tilt_rad=vehicle.sonar.elevation_rad if vehicle.sonars else math.nan,
        gimbal_rad=gimbal_rad,
        camera_tilt=camera_tilt,
        lights=sum(lamps) / len(lamps) if lamps else math.nan,
        gps=by_kind["gps"].sample() if "gps" in by_kind else None,
    )


def _reading(sensors: dict[str, Any], kind: str, otherwise: float) -> float:
    return float(sensors[kind].read()) if kind in sensors else otherwise


def _gimbal_of(vehicle: Vehicle) -> tuple[tuple[float, float], float]:
    for camera in vehicle.cameras.values():
        motor = camera.mount.pan_tilt
        if motor is not None:
            pan, tilt = camera.aim_rad
            low, high = (math.radians(limit) for limit in motor.tilt_limits_deg)
            return (-tilt, -pan), (high - tilt) / (high - low) if high > low else math.nan
    return (math.nan, math.nan), math.nan


def _imu(sensors: Mapping[str, Any]) -> Vector:
    if "imu" not in sensors:
        return np.full(6, math.nan)
    reading = sensors["imu"].read()
    return np.concatenate([reading.linear_acceleration_m_s2, reading.angular_velocity_rad_s])


def _variances(covariance: Vector) -> tuple[float, float, float, float]:
    """Return the variances of State; see Navigator.covariance."""
    position, velocity, attitude = np.diagonal(covariance)[:9].reshape(3, 3)
    return float(velocity.max()), float(position[:2].max()), float(position[2]), float(attitude[2])


def _sensor_bits(sensors: Mapping[str, Any], *, is_placed: bool, charge: float) -> tuple[int, int]:
    """Return what the vehicle has, and what of it works, as ArduSub does; a sensor without a valid sample does not."""
    present = CONTROLS | MOTORS | AHRS | BATTERY | PREARM | POSITION
    ill = (0 if is_placed else POSITION) | (BATTERY if charge <= 0 else 0)
    for kind, bits in SENSORS.items():
        if kind in sensors:
            present |= bits
            ill |= 0 if sensors[kind].sample().valid else bits
    return present, present & ~ill
