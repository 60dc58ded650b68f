"""Targets in GUIDED: positions, velocities, and attitudes with a rate of climb."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.bridges.actions.action import Route
from uwsim.bridges.actions.table import SPEED_M_S
from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.component import DONE, UNSUPPORTED, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU, Vector, euler_rad
from uwsim.bridges.mavlink.flight import Flight
from uwsim.bridges.mavlink.modes import GUIDED, HOLDS_OF
from uwsim.bridges.mavlink.state import State
from uwsim.missions.items import FAR_M
from uwsim.missions.moves import SPEED_MAX_M_S

LOCAL, LOCAL_OFFSET, BODY, BODY_OFFSET, BODY_FRD = 1, 7, 8, 9, 12  # MAV_FRAME
GLOBAL_FRAMES = (0, 3, 5, 6)
POSITION_IGNORED, HORIZONTAL_IGNORED, VELOCITY_IGNORED, ACCELERATION_IGNORED = (
    0b111,
    0b011,
    0b111 << 3,
    0b111 << 6,
)  # POSITION_TARGET_TYPEMASK
YAW_IGNORED, YAW_RATE_IGNORED = 1 << 10, 1 << 11
THRUST_IGNORED, ATTITUDE_IGNORED = 1 << 6, 1 << 7  # ATTITUDE_TARGET_TYPEMASK
RELATIVE_YAW = 2  # MAV_DO_REPOSITION_FLAGS
DEGREES_E7 = 1e-7
TURN_PER_S, TURN_MAX_RAD_S = 1.0, 0.5
"""The rate at which an attitude is approached, per radian of error, and its limit."""
TILT_MAX_RAD = math.radians(45)  # ArduSub's ANGLE_MAX


class Targets:
    """Flies to targets while the vehicle is armed and in GUIDED.

    apply: applies a velocity (6,) in body axes through a channel, which brings the vehicle to rest if no more targets
    arrive; None if the vehicle cannot be steered.
    """

    def __init__(self, craft: Craft, flight: Flight, apply: Callable[[Vector], None] | None) -> None:
        self._craft, self._flight, self._apply = craft, flight, apply

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD."""
        return {192: self._on_reposition}

    def _on_reposition(self, given: Given) -> int:
        if given.frame not in GLOBAL_FRAMES:
            return UNSUPPORTED
        speed_m_s, yaw = given.real(1, may_be_nan=True), given.real(4, may_be_nan=True)
        is_default = math.isnan(speed_m_s) or speed_m_s in (-1, 0)
        if not (is_default or 0 < speed_m_s <= SPEED_MAX_M_S):
            raise given.denied(1, f"a speed in (0, {SPEED_MAX_M_S:g}] m/s, or -1 for the default")
        turns = math.isfinite(yaw) and yaw != 0
        if given.integer(2, 0, 255) & RELATIVE_YAW and turns:
            raise given.denied(2, "without the flag of a relative yaw (2)")
        lat_deg, lon_deg = (DEGREES_E7 * given.real(index) for index in (5, 6))
        point = self._craft.home.world_m(lat_deg, lon_deg, given.real(7))
        self._flight.require_armed("target")
        self._fly_to(point, math.pi / 2 - yaw if turns else None, SPEED_M_S if is_default else speed_m_s)
        return DONE

    def on_set_position_target_local_ned(self, peer: Address, message: Any) -> None:
        """Fly to a position, relative to the origin or to the vehicle, or at a velocity."""
        frame = message.coordinate_frame
        if frame not in (LOCAL, LOCAL_OFFSET, BODY, BODY_OFFSET, BODY_FRD):
            raise ValueError(f"target: frame {frame}: must be local NED (1), or along NED (7) or the body (8, 9, 12)")
        state = self._require_guided()
        is_body = frame in (BODY, BODY_OFFSET, BODY_FRD)
        if message.type_mask & POSITION_IGNORED:
            self._steer(message, state, [message.vx, message.vy, message.vz], is_body=is_body)
            return
        offset = np.array([message.x, message.y, message.z])
        if not np.isfinite(offset).all():
            raise ValueError(f"target = {offset.tolist()} m: must be numbers")
        point = NED_FROM_ENU.T @ (_levelled(state, offset) if is_body else offset)
        self._guide(message, point if frame == LOCAL else state.position_world_m + point)

    def on_set_position_target_global_int(self, peer: Address, message: Any) -> None:
        """Fly to a geographic location, or at a velocity."""
        if message.coordinate_frame not in GLOBAL_FRAMES:
            rule = "must be a global one (0, 3, 5, 6); heights above the bed (10, 11) are for missions"
            raise ValueError(f"target: frame {message.coordinate_frame}: {rule}")
        place = DEGREES_E7 * message.lat_int, DEGREES_E7 * message.lon_int
        if message.type_mask & POSITION_IGNORED == HORIZONTAL_IGNORED and self._holds("depth"):
            self._hold_depth(message.alt)
            return
        state = self._require_guided()
        if message.type_mask & POSITION_IGNORED:
            self._steer(message, state, [message.vx, message.vy, message.vz], is_body=False)
            return
        self._guide(message, self._craft.home.world_m(*place, message.alt))

    def _holds(self, name: str) -> bool:
        """Return whether a hold is active in a mode flown with sticks, in which ArduSub, too, steers targets."""
        return self._flight.is_by_sticks and name in HOLDS_OF[self._flight.mode]

    def _hold_depth(self, altitude_m: float) -> None:
        if not -FAR_M < altitude_m <= 0.0:  # of the surface is 0
            raise ValueError(f"target: alt = {altitude_m:g} m: must be a number, at most 0")
        self._craft.command("hold_at", z_world_m=altitude_m)

    def on_set_attitude_target(self, peer: Address, message: Any) -> None:
        """Turn to an attitude, and climb: half of the thrust keeps the depth, as for ArduSub.

        Without thrust, in a mode that holds the heading, it is the heading's target.
        """
        without_thrust = bool(message.type_mask & THRUST_IGNORED) and self._holds("heading")
        if message.type_mask & ATTITUDE_IGNORED or (message.type_mask & THRUST_IGNORED and not without_thrust):
            rule = "attitude and thrust must be given; the attitude alone where the heading is held, as in ALT_HOLD"
            raise ValueError(f"SET_ATTITUDE_TARGET: type_mask = {message.type_mask}: {rule}")
        q, thrust = np.array(message.q), 0.5 if without_thrust else message.thrust
        if not abs(np.linalg.norm(q) - 1) <= 0.01 or not 0 <= thrust <= 1:
            values = f"q = {q.tolist()}, thrust = {thrust:g}"
            raise ValueError(f"SET_ATTITUDE_TARGET: {values}: must have the length 1, and be in [0, 1]")
        yaw, pitch, roll = Rotation.from_quat(q, scalar_first=True).as_euler("ZYX")
        tilts = {"pitch": pitch, "roll": roll}
        drives = self._craft.vehicle.controllable
        if any(abs(tilt) > (TILT_MAX_RAD if axis in drives else 0.02) for axis, tilt in tilts.items()):
            degrees = {axis: round(math.degrees(tilt), 1) for axis, tilt in tilts.items()}
            raise ValueError(f"SET_ATTITUDE_TARGET: {degrees} deg: must be at most 45, and 0 where nothing drives it")
        if without_thrust:
            self._craft.command("hold_at", heading_rad=math.pi / 2 - yaw)
            return
        state = self._require_guided()
        ahead = np.array([0.0, 0.0, -2 * SPEED_M_S * (thrust - 0.5)])
        self._steer_by(state, ahead, _rates(state, roll, pitch, yaw))

    def _require_guided(self) -> State:
        """Return the present state. Raises ValueError unless targets have an effect."""
        self._flight.require_armed("target")
        if self._flight.mode != GUIDED:
            raise ValueError("target: must be in mode GUIDED")
        if self._craft.state is None:
            raise ValueError("target: the vehicle's position is not known yet")
        return self._craft.state

    def _guide(self, message: Any, point: Vector) -> None:
        self._fly_to(point, None if message.type_mask & YAW_IGNORED else math.pi / 2 - message.yaw)

    def _fly_to(self, point: Vector, heading_rad: float | None, speed_m_s: float = SPEED_M_S) -> None:
        if not (all(math.isfinite(part) and abs(part) < FAR_M for part in point) and point[2] <= 0):
            raise ValueError(
                f"target = {[round(float(part), 2) for part in point]} m: must be near, and not above water"
            )
        if heading_rad is not None and not math.isfinite(heading_rad):
            raise ValueError("target: yaw: must be a number")
        self._flight.fly_to(Route(point.reshape(1, 3), speed_m_s, heading_rad))

    def _steer(self, message: Any, state: State, velocity: list[float], *, is_body: bool) -> None:
        """Fly at a velocity along north, east and down, or along the heading, to its right, and down."""
        mask, values = message.type_mask, np.array([*velocity, message.yaw, message.yaw_rate])
        if mask & VELOCITY_IGNORED or mask & ACCELERATION_IGNORED != ACCELERATION_IGNORED:
            raise ValueError(f"target: type_mask = {mask}: must be positions or velocities, without accelerations")
        if mask & YAW_IGNORED:
            values[3] = 0.0
        if mask & YAW_RATE_IGNORED:
            values[4] = 0.0
        if not (np.isfinite(values).all() and np.abs(values[:3]).max() <= SPEED_MAX_M_S and abs(values[4]) <= math.tau):
            raise ValueError(f"target: velocity and yaw = {values.tolist()}: must be at most {SPEED_MAX_M_S:g} m/s")
        rates = np.array([0.0, 0.0, values[4]]) if mask & YAW_IGNORED else _rates(state, 0.0, 0.0, values[3])
        self._steer_by(state, _levelled(state, values[:3]) if is_body else values[:3], rates)

    def _steer_by(self, state: State, velocity_ned: Vector, rates_frd: Vector) -> None:
        if self._apply is None:
            raise ValueError("target: the vehicle cannot be steered")
        linear = state.world_from_body[:3, :3].T @ (NED_FROM_ENU.T @ velocity_ned)
        self._flight.begin_steering()
        self._apply(np.concatenate([linear, rates_frd * FRD]))


def _levelled(state: State, ahead: Vector) -> Vector:
    """Convert a vector along the heading, to its right and down to north, east and down."""
    yaw = euler_rad(state.world_from_body)[2]
    forward, right, down = ahead
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.array([cosine * forward - sine * right, sine * forward + cosine * right, down])


def _rates(state: State, roll: float, pitch: float, yaw: float) -> Vector:
    """Return the rates about the axes forward, right and down [rad/s] that lead to an attitude."""
    now = euler_rad(state.world_from_body)
    errors = [math.remainder(wanted - is_, math.tau) for wanted, is_ in zip((roll, pitch, yaw), now, strict=True)]
    return np.clip(TURN_PER_S * np.array(errors), -TURN_MAX_RAD_S, TURN_MAX_RAD_S)
