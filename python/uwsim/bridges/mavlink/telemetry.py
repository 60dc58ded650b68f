"""The messages with which a MAVLink vehicle reports its state, made from a single reading of the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU, Home, Vector, euler_rad
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

UNKNOWN_U16, UNKNOWN_I16 = 0xFFFF, 0x7FFF
ULTRASOUND, DOWN = 1, 25  # MAV_DISTANCE_SENSOR, MAV_SENSOR_ORIENTATION
YAW_IN_VEHICLE = 32  # GIMBAL_DEVICE_FLAGS
SENSORS = {"imu": 0x1 | 0x2, "compass": 0x4, "pressure": 0x8, "depth": 0x8, "altitude": 0x100}
"""MAV_SYS_STATUS_SENSOR by kind: gyroscope and accelerometer, magnetometer, absolute pressure, range finder."""
HPA_PER_PA = 0.01


class State(NamedTuple):
    """One reading. position_world_m: estimated, unless the truth is published. velocity_body: (6,).

    gimbal_rad: pitch (positive up) and yaw (positive to the right) of the first camera with a motor. camera_tilt: that
    camera's pitch as a fraction of its range, from 0 (lowest) to 1. lights: the fraction of lamps that are on. Values
    that do not exist are NaN.
    """

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
    gimbal_rad: tuple[float, float]
    camera_tilt: float
    lights: float


def read(sim: Simulator, source: Source, *, truth: bool) -> State:
    """Return the current state. Must be called on the simulator's thread."""
    vehicle = source.of(sim)
    mover = vehicle if truth else vehicle.estimate
    pose, velocity = mover.pose, mover.velocity
    panel, holds = vehicle.telemetry(), vehicle.holds
    failsafe = vehicle.failsafe
    gimbal_rad, camera_tilt = _gimbal_of(vehicle)
    lamps = [lamp.on for lamp in vehicle.lamps.values()]
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
        gimbal_rad=gimbal_rad,
        camera_tilt=camera_tilt,
        lights=sum(lamps) / len(lamps) if lamps else math.nan,
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


def _present(vehicle: Vehicle) -> int:
    bits = 0
    for sensor in vehicle.sensors.values():
        bits |= SENSORS.get(sensor.kind, 0)
    return bits


class Figures:
    """The values of one reading in MAVLink's units and axes, computed once for all messages."""

    def __init__(self, state: State, home: Home) -> None:
        self.state, self.home = state, home
        self.ms = round(1e3 * state.time_s) % 2**32
        self.roll, self.pitch, self.yaw = euler_rad(state.world_from_body)
        self.rates_rad_s = state.velocity_body[3:] * FRD
        self.velocity_ned_m_s = NED_FROM_ENU @ (state.world_from_body[:3, :3] @ state.velocity_body[:3])
        self.position_ned_m = NED_FROM_ENU @ state.position_world_m
        lat_deg, lon_deg = home.degrees(state.position_world_m)
        self.lat_e7, self.lon_e7 = round(1e7 * lat_deg), round(1e7 * lon_deg)
        self.heading_cdeg = round(100 * math.degrees(self.yaw)) % 36000
        percent = state.battery_percent
        self.percent = -1 if math.isnan(percent) else min(max(round(percent), 0), 100)


Maker = Callable[[Any, Figures], Iterable[Any]]
"""Returns the messages of one kind. The first argument is pymavlink's MAVLink object, which encodes them."""


def _position(mav: Any, f: Figures) -> Iterable[Any]:
    up_mm = round(1e3 * f.state.position_world_m[2])
    speeds = (_int16(100 * part) for part in f.velocity_ned_m_s)
    return [mav.global_position_int_encode(f.ms, f.lat_e7, f.lon_e7, up_mm, up_mm, *speeds, f.heading_cdeg)]


def _hud(mav: Any, f: Figures) -> Iterable[Any]:
    north, east, down = f.velocity_ned_m_s
    speed = float(np.hypot(north, east))
    altitude_m = -f.position_ned_m[2]
    return [mav.vfr_hud_encode(speed, speed, f.heading_cdeg // 100, f.state.throttle_percent, altitude_m, -down)]


def _status(mav: Any, f: Figures) -> Iterable[Any]:
    sensors = [f.state.sensors] * 3
    return [mav.sys_status_encode(*sensors, 0, UNKNOWN_U16, -1, f.percent, 0, 0, 0, 0, 0, 0)]


def _battery(mav: Any, f: Figures) -> Iterable[Any]:
    return [mav.battery_status_encode(0, 0, 0, UNKNOWN_I16, [UNKNOWN_U16] * 10, -1, -1, -1, f.percent)]


def _pressure(mav: Any, f: Figures) -> Iterable[Any]:
    temperature_cdeg = _int16(100 * f.state.temperature_deg_c)
    return [mav.scaled_pressure2_encode(f.ms, HPA_PER_PA * f.state.pressure_pa, 0.0, temperature_cdeg)]


def _range(mav: Any, f: Figures) -> Iterable[Any]:
    return [mav.rangefinder_encode(f.state.altitude_m, 0.0)] if math.isfinite(f.state.altitude_m) else []


def _distance(mav: Any, f: Figures) -> Iterable[Any]:
    if not math.isfinite(f.state.altitude_m):
        return []
    centimetres = min(max(round(100 * f.state.altitude_m), 0), UNKNOWN_U16)
    return [mav.distance_sensor_encode(f.ms, 0, UNKNOWN_U16, centimetres, ULTRASOUND, 0, DOWN, 255)]


def _named(mav: Any, f: Figures) -> Iterable[Any]:
    named = {"SonarTilt": f.state.tilt_rad, "CamTilt": f.state.camera_tilt, "Lights1": f.state.lights}
    return [mav.named_value_float_encode(f.ms, name.encode(), v) for name, v in named.items() if math.isfinite(v)]


def _gimbal(mav: Any, f: Figures) -> Iterable[Any]:
    pitch, yaw = f.state.gimbal_rad
    if math.isnan(pitch):
        return []
    cp, sp, cy, sy = math.cos(pitch / 2), math.sin(pitch / 2), math.cos(yaw / 2), math.sin(yaw / 2)
    q = [cy * cp, -sy * sp, cy * sp, sy * cp]
    unknown = [math.nan] * 3
    return [mav.gimbal_device_attitude_status_encode(0, 0, f.ms, YAW_IN_VEHICLE, q, *unknown, 0, gimbal_device_id=1)]


def place(mav: Any, home: Home) -> Any:
    """Return HOME_POSITION."""
    lat, lon = round(1e7 * home.lat_deg), round(1e7 * home.lon_deg)
    return mav.home_position_encode(lat, lon, 0, 0.0, 0.0, 0.0, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0)


def origin(mav: Any, home: Home) -> Any:
    """Return GPS_GLOBAL_ORIGIN."""
    return mav.gps_global_origin_encode(round(1e7 * home.lat_deg), round(1e7 * home.lon_deg), 0)


class Kind(NamedTuple):
    """A kind of message: its ID, the function that makes it, its default rate and its stream (MAV_DATA_STREAM)."""

    number: int
    make: Maker
    rate_hz: float
    stream: int


EXTENDED_STATUS, POSITION, EXTRA1, EXTRA2, EXTRA3, RAW_SENSORS = 2, 6, 10, 11, 12, 1  # MAV_DATA_STREAM
KINDS = [
    Kind(30, lambda mav, f: [mav.attitude_encode(f.ms, f.roll, f.pitch, f.yaw, *f.rates_rad_s)], 10, EXTRA1),
    Kind(
        32, lambda mav, f: [mav.local_position_ned_encode(f.ms, *f.position_ned_m, *f.velocity_ned_m_s)], 10, POSITION
    ),
    Kind(33, _position, 10, POSITION),
    Kind(137, _pressure, 10, RAW_SENSORS),
    Kind(74, _hud, 10, EXTRA2),
    Kind(1, _status, 10, EXTENDED_STATUS),
    Kind(147, _battery, 10, EXTRA3),
    Kind(173, _range, 10, EXTRA3),
    Kind(251, _named, 10, EXTRA3),
    Kind(285, _gimbal, 10, EXTRA3),
    Kind(2, lambda mav, f: [mav.system_time_encode(0, f.ms)], 1, EXTRA3),
    Kind(
        178,
        lambda mav, f: [mav.ahrs2_encode(f.roll, f.pitch, f.yaw, -f.position_ned_m[2], f.lat_e7, f.lon_e7)],
        0,
        EXTRA1,
    ),
    Kind(132, _distance, 0, EXTRA3),
    Kind(242, lambda mav, f: [place(mav, f.home)], 0, EXTENDED_STATUS),
    Kind(49, lambda mav, f: [origin(mav, f.home)], 0, EXTENDED_STATUS),
]
"""All telemetry messages. Adding a message takes one entry."""


def _int16(value: float) -> int:
    return min(max(round(value), -0x7FFF), 0x7FFF) if math.isfinite(value) else UNKNOWN_I16
