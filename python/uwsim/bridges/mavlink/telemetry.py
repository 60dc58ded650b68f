"""The messages with which a MAVLink vehicle reports its state, made from a single reading of the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU, Vector, euler_rad, ned_from_frd
from uwsim.bridges.mavlink.state import CONTROLS, POSITION, PREARM, State
from uwsim.mapping.files.georeference import Place

UNKNOWN_U16, UNKNOWN_I16 = 0xFFFF, 0x7FFF
ULTRASOUND, DOWN = 1, 25  # MAV_DISTANCE_SENSOR, MAV_SENSOR_ORIENTATION
YAW_IN_VEHICLE = 32  # GIMBAL_DEVICE_FLAGS
LIGHTS, TILT = 13, 16
"""Servo outputs, as a BlueROV2 with the Navigator board assigns them."""
THROTTLE_US, FULL_US, OFF_US = 1500, 400, 1100
HPA_PER_PA = 0.01
STANDARD_GRAVITY_M_S2 = 9.80665
ATTITUDE_AND_VELOCITY, POSITION_KNOWN = 0x27, 0x318  # EKF_STATUS_FLAGS; the height comes from the pressure
NO_FIX, FIX_3D = 1, 3  # GPS_FIX_TYPE
LANDED, UNDER_WAY = 1, 2  # MAV_LANDED_STATE
LOCAL_NED, BODY_FRD = 1, 12  # MAV_FRAME


class Figures:
    """The values of one reading in MAVLink's units and axes, computed once for all messages."""

    def __init__(self, state: State, craft: Craft) -> None:
        self.state, self.craft = state, craft
        self.us = round(1e6 * state.time_s)
        self.ms = round(1e3 * state.time_s) % 2**32
        self.roll, self.pitch, self.yaw = euler_rad(state.world_from_body)
        self.rates_rad_s = state.velocity_body[3:] * FRD
        self.velocity_ned_m_s = NED_FROM_ENU @ (state.world_from_body[:3, :3] @ state.velocity_body[:3])
        self.position_ned_m = NED_FROM_ENU @ state.position_world_m
        lat_deg, lon_deg = craft.home.degrees(state.position_world_m)
        self.lat_e7, self.lon_e7 = round(1e7 * lat_deg), round(1e7 * lon_deg)
        self.heading_cdeg = round(100 * math.degrees(self.yaw)) % 36000
        percent = state.battery_percent
        self.current_ca = _int16(100 * state.current_a) if math.isfinite(state.current_a) else -1
        self.is_placed = bool(state.healthy & POSITION)
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


HEIGHT_CONTROL, PLACE_CONTROL, GEOFENCE = 0x2000, 0x4000, 1 << 20  # MAV_SYS_STATUS_SENSOR


def _status(mav: Any, f: Figures) -> Iterable[Any]:
    state, craft = f.state, f.craft
    off = 0 if craft.is_flying or {"depth", "altitude"} & {*state.holds} else HEIGHT_CONTROL
    off |= 0 if craft.is_flying or "position" in state.holds else PLACE_CONTROL
    healthy = state.healthy if state.can_arm else state.healthy & ~PREARM
    known = state.sensors, state.sensors & ~(off & CONTROLS), healthy
    bits = (bit | GEOFENCE * fence for bit, fence in zip(known, craft.fence, strict=True))  # as AP_Fence's sys_status
    voltage_mv = _uint16(1e3 * state.voltage_v)
    return [mav.sys_status_encode(*bits, 0, voltage_mv, f.current_ca, f.percent, 0, 0, 0, 0, 0, 0)]


def _battery(mav: Any, f: Figures) -> Iterable[Any]:
    voltages_mv = [_uint16(1e3 * f.state.voltage_v), *[UNKNOWN_U16] * 9]
    consumed_mah = round(1e3 * f.state.consumed_ah) if math.isfinite(f.state.consumed_ah) else -1
    return [mav.battery_status_encode(0, 0, 0, UNKNOWN_I16, voltages_mv, f.current_ca, consumed_mah, -1, f.percent)]


def _pulses_us(thrusters: tuple[float, ...], lights: float, camera_tilt: float) -> list[int]:
    """Return the pulses of 16 outputs; 0: unused. thrusters: commands. lights, camera_tilt: from 0 to 1, or NaN."""
    found = [0] * 16
    for k, command in enumerate(thrusters[: LIGHTS - 1]):
        found[k] = round(THROTTLE_US + FULL_US * command)
    for output, share in ((LIGHTS, lights), (TILT, camera_tilt)):
        if share == share:  # not NaN
            found[output - 1] = round(OFF_US + 2 * FULL_US * share)
    return found


def _servos(mav: Any, f: Figures) -> Iterable[Any]:
    pulses = _pulses_us(f.state.thrusters, f.state.lights, f.state.camera_tilt)
    return [mav.servo_output_raw_encode(f.us % 2**32, 0, *pulses)]


def _channels(mav: Any, f: Figures) -> Iterable[Any]:
    pulses = f.craft.channels_us
    known = [pulses.get(k, UNKNOWN_U16) for k in range(1, 19)]
    return [mav.rc_channels_encode(f.ms, max(pulses, default=0), *known, 255)]


def _imu(mav: Any, f: Figures) -> Iterable[Any]:
    """Return SCALED_IMU: thousandths of g and of rad/s; the compass measures no field, so that is 0, unknown."""
    if math.isnan(f.state.imu[0]):
        return []
    force, rates = f.state.imu.reshape(2, 3) * FRD
    values = [_int16(part) for part in (*(1e3 / STANDARD_GRAVITY_M_S2 * force), *(1e3 * rates))]
    return [mav.scaled_imu_encode(f.ms, *values, 0, 0, 0)]


def _filter(mav: Any, f: Figures) -> Iterable[Any]:
    flags = ATTITUDE_AND_VELOCITY | (POSITION_KNOWN if f.is_placed else 0)
    velocity, position, height, heading = f.state.variances
    return [mav.ekf_status_report_encode(flags, velocity, position, height, heading, 0.0)]


def _fix(mav: Any, f: Figures) -> Iterable[Any]:
    """Return GPS_RAW_INT: the vehicle's GPS; without one its own position, as if a positioning system gave it."""
    is_fixed, position_m, velocity_ned, lat_e7, lon_e7 = (
        f.is_placed, f.state.position_world_m, f.velocity_ned_m_s, f.lat_e7, f.lon_e7
    )  # fmt: skip
    horizontal_m, vertical_m = math.sqrt(f.state.variances[1]), math.sqrt(f.state.variances[2])
    if f.state.gps is not None:
        is_fixed, horizontal_m, vertical_m = f.state.gps.valid, 0.0, 0.0  # 0: unknown
        if not is_fixed:
            return [mav.gps_raw_int_encode(f.us, NO_FIX, 0, 0, 0, *[UNKNOWN_U16] * 4, 255)]
        position_m, velocity_ned = f.state.gps.value.position_m, NED_FROM_ENU @ f.state.gps.value.velocity_m_s
        lat_e7, lon_e7 = (round(1e7 * degrees) for degrees in f.craft.home.degrees(position_m))
    north, east, _ = velocity_ned
    course_cdeg = round(100 * math.degrees(math.atan2(east, north))) % 36000
    return [
        mav.gps_raw_int_encode(
            f.us, FIX_3D if is_fixed else NO_FIX, lat_e7, lon_e7, round(1e3 * position_m[2]), UNKNOWN_U16, UNKNOWN_U16,
            _uint16(100 * math.hypot(north, east)), course_cdeg, 255, 0, round(1e3 * horizontal_m),
            round(1e3 * vertical_m),
        )
    ]  # fmt: skip


def odometry(mav: Any, us: int, frame: int, position_world_m: Vector, xyzw: Vector, velocity_body: Vector) -> Any:
    """Return ODOMETRY for a pose and velocities (6,) in body axes. frame: MAV_FRAME of the pose."""
    linear, angular = velocity_body.reshape(2, 3) * FRD
    unknown = [math.nan] * 21
    position = (NED_FROM_ENU @ position_world_m).tolist()
    q = ned_from_frd(xyzw)
    return mav.odometry_encode(us, frame, BODY_FRD, *position, q, *linear.tolist(), *angular.tolist(), unknown, unknown)


def _odometry(mav: Any, f: Figures) -> Iterable[Any]:
    xyzw = Rotation.from_matrix(f.state.world_from_body[:3, :3]).as_quat()
    return [odometry(mav, f.us, LOCAL_NED, f.state.position_world_m, xyzw, f.state.velocity_body)]


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
    named = {"SonarTilt": f.state.tilt_rad, "CamTilt": f.state.camera_tilt, "Lights1": f.state.lights,
             "PilotGain": f.craft.gain}  # fmt: skip
    return [mav.named_value_float_encode(f.ms, name.encode(), v) for name, v in named.items() if math.isfinite(v)]


def _gimbal(mav: Any, f: Figures) -> Iterable[Any]:
    pitch, yaw = f.state.gimbal_rad
    if math.isnan(pitch):
        return []
    cp, sp, cy, sy = math.cos(pitch / 2), math.sin(pitch / 2), math.cos(yaw / 2), math.sin(yaw / 2)
    q = [cy * cp, -sy * sp, cy * sp, sy * cp]
    unknown = [math.nan] * 3
    return [mav.gimbal_device_attitude_status_encode(0, 0, f.ms, YAW_IN_VEHICLE, q, *unknown, 0, gimbal_device_id=1)]


def place(mav: Any, craft: Craft) -> Any:
    """Return HOME_POSITION: where the vehicle was armed, at the surface; the world's origin before."""
    home = craft.launch_world_m
    lat, lon = (round(1e7 * degrees) for degrees in craft.home.degrees(home))
    return mav.home_position_encode(lat, lon, 0, *(NED_FROM_ENU @ home), [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0)


def origin(mav: Any, home: Place) -> Any:
    """Return GPS_GLOBAL_ORIGIN."""
    return mav.gps_global_origin_encode(*(round(1e7 * degrees) for degrees in home.degrees(np.zeros(3))), 0)


class Kind(NamedTuple):
    """A kind of message: its ID, the function that makes it, its default rate and its stream (MAV_DATA_STREAM)."""

    number: int
    make: Maker
    rate_hz: float
    stream: int


EXTENDED_STATUS, POSITION_STREAM, EXTRA1, EXTRA2, EXTRA3, RAW_SENSORS, RC_VALUES = 2, 6, 10, 11, 12, 1, 3
"""MAV_DATA_STREAM."""
KINDS = [
    Kind(30, lambda mav, f: [mav.attitude_encode(f.ms, f.roll, f.pitch, f.yaw, *f.rates_rad_s)], 10, EXTRA1),
    Kind(
        32, lambda mav, f: [mav.local_position_ned_encode(f.ms, *f.position_ned_m, *f.velocity_ned_m_s)], 10,
        POSITION_STREAM,
    ),
    Kind(33, _position, 10, POSITION_STREAM),
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
    Kind(242, lambda mav, f: [place(mav, f.craft)], 0, EXTENDED_STATUS),
    Kind(49, lambda mav, f: [origin(mav, f.craft.home)], 0, EXTENDED_STATUS),
    Kind(36, _servos, 4, RC_VALUES),
    Kind(65, _channels, 4, RC_VALUES),
    Kind(26, _imu, 4, RAW_SENSORS),
    Kind(193, _filter, 2, EXTRA3),
    Kind(24, _fix, 5, EXTENDED_STATUS),
    Kind(245, lambda mav, f: [mav.extended_sys_state_encode(0, UNDER_WAY if f.state.released else LANDED)], 1,
         EXTENDED_STATUS),
    Kind(331, _odometry, 0, POSITION_STREAM),
]  # fmt: skip
"""All telemetry messages. Adding a message takes one entry."""


def _int16(value: float) -> int:
    return min(max(round(value), -0x7FFF), 0x7FFF) if math.isfinite(value) else UNKNOWN_I16


def _uint16(value: float) -> int:
    return min(max(round(value), 0), UNKNOWN_U16 - 1) if math.isfinite(value) else UNKNOWN_U16
