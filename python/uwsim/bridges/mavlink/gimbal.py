"""The gimbal manager (https://mavlink.io/en/services/gimbal_v2.html) for a camera with a pan-tilt motor."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from typing import Any

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.component import DENIED, DONE, UNSUPPORTED, Component, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.state import State
from uwsim.bridges.mavlink.telemetry import EXTRA3, Kind

DEVICE = 1
"""The gimbal device's ID; 1 to 6 are for devices that do not use MAVLink themselves."""
INFORMATION, STATUS, DEVICE_INFORMATION = 280, 281, 283  # messages
PITCH_AXIS, PITCH_FOLLOW, YAW_AXIS, YAW_FOLLOW = 1 << 3, 1 << 4, 1 << 6, 1 << 7  # GIMBAL_MANAGER_CAP_FLAGS
RETRACT, NEUTRAL, YAW_LOCK, YAW_IN_EARTH = 1, 2, 16, 64  # GIMBAL_MANAGER_FLAGS
STATUS_HZ = 0.2
RATE_LASTS_S = 1.0
STICK_RAD_S = math.radians(30)
"""The turn rate at full deflection or while a button is pressed: ArduSub's MNT1_RC_RATE."""
MOUNT_RETRACT, MOUNT_NEUTRAL, MOUNT_TARGETING, MOUNT_MODES = 0, 1, 2, 7  # MAV_MOUNT_MODE, and how many there are
MINE, RELEASE = -2, -3  # special IDs in DO_GIMBAL_MANAGER_CONFIGURE


class Gimbal:
    """Turns the first of a vehicle's cameras that has a motor.

    Pitch (positive up) and yaw (positive to the right) are relative to the direction in which the camera is mounted.
    The mount moves with the vehicle, so no axis can be locked to the horizon or to north. Once a ground station has
    requested control, other stations' gimbal manager commands are denied. camera: the camera's name, or "" if there is
    none; every command is then answered as unsupported.
    """

    def __init__(self, craft: Craft, component: Component) -> None:
        self._craft, self._component = craft, component
        turning = [name for name, camera in craft.vehicle.cameras.items() if camera.mount.pan_tilt is not None]
        self.camera = next(iter(turning), "")
        motor = craft.vehicle.cameras[self.camera].mount.pan_tilt if turning else None
        low, high = motor.tilt_limits_deg if motor else (0.0, 0.0)
        left, right = motor.pan_limits_deg if motor else (0.0, 0.0)
        self._pitch_limits_rad = math.radians(-high), math.radians(-low)
        self._yaw_limits_rad = math.radians(-right), math.radians(-left)
        self._owner = (0, 0)  # the station in control
        self._rates_rad_s = (0.0, 0.0)
        self._rates_end_s = 0.0
        self._turned_s = math.nan  # simulated time of the last turn at a rate
        self._wanted_rad = (0.0, 0.0)

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD."""
        if not self.camera:
            return {}
        return {204: self._on_mount_mode, 205: self._on_mount, 1000: self._on_pitch_yaw, 1001: self._on_configure}

    @property
    def kinds(self) -> list[Kind]:
        """The messages that are sent at a fixed rate."""
        return [Kind(STATUS, lambda mav, figures: [self.status()], STATUS_HZ, EXTRA3)] if self.camera else []

    def answer(self, number: int, value: float) -> Iterable[Any] | None:
        """Return the message with an ID; see Answers."""
        if not self.camera or number not in (INFORMATION, DEVICE_INFORMATION):
            return None
        flags = (PITCH_AXIS | PITCH_FOLLOW) * self._can_turn(self._pitch_limits_rad)
        flags |= (YAW_AXIS | YAW_FOLLOW) * self._can_turn(self._yaw_limits_rad)
        limits = 0.0, 0.0, *self._pitch_limits_rad, *self._yaw_limits_rad
        mav, name = self._component.mav, self.camera.encode()[:31]
        if number == INFORMATION:
            return [mav.gimbal_manager_information_encode(self._ms, flags, DEVICE, *limits)]
        return [
            mav.gimbal_device_information_encode(
                self._ms, b"uwsim", name, b"", 0, 0, 0, flags, 0, *limits, gimbal_device_id=DEVICE
            )
        ]

    def status(self) -> Any:
        """Return GIMBAL_MANAGER_STATUS."""
        return self._component.mav.gimbal_manager_status_encode(self._ms, 0, DEVICE, *self._owner, 0, 0)

    @property
    def _ms(self) -> int:
        return 0 if self._craft.state is None else round(1e3 * self._craft.state.time_s) % 2**32

    @staticmethod
    def _can_turn(limits: tuple[float, float]) -> bool:
        return limits[0] < limits[1]

    @property
    def angles_rad(self) -> tuple[float, float]:
        """The target pitch and yaw of the camera."""
        pan, tilt = self._craft.vehicle.cameras[self.camera].target_rad
        return -tilt, -pan

    def turn_to(self, pitch_rad: float, yaw_rad: float) -> None:
        """Turn to these angles. NaN leaves an axis unchanged. Raises ValueError beyond the motor's limits."""
        self._rates_rad_s = (0.0, 0.0)
        self._command(pitch_rad, yaw_rad)

    def _command(self, pitch_rad: float, yaw_rad: float) -> None:
        for name, angle, (low, high) in (
            ("pitch", pitch_rad, self._pitch_limits_rad), ("yaw", yaw_rad, self._yaw_limits_rad)
        ):  # fmt: skip
            if math.isinf(angle) or angle < low - 1e-6 or angle > high + 1e-6:
                bounds = f"[{math.degrees(low):g}, {math.degrees(high):g}]"
                raise ValueError(f"gimbal: {name} = {math.degrees(angle):g} deg: must be in {bounds} deg")
        tilt, pan = (None if math.isnan(angle) else -angle for angle in (pitch_rad, yaw_rad))
        if tilt is not None or pan is not None:
            self._craft.send("aim_camera", camera=self.camera, pan_rad=pan, tilt_rad=tilt)

    def centre(self) -> None:
        """Turn to the direction in which the camera is mounted."""
        if self.camera:
            self.turn_to(0.0, 0.0 if self._can_turn(self._yaw_limits_rad) else math.nan)

    def turn_to_share(self, share: float) -> None:
        """Turn to a pitch, as a share of the motor's range from 0 (lowest) to 1, limited to it."""
        low, high = self._pitch_limits_rad
        self.turn_to(low + min(max(share, 0.0), 1.0) * (high - low), math.nan)

    def turn_by_stick(self, pitch: float, yaw: float) -> None:
        """Turn for up to a second at a rate set by stick deflections in [-1, 1]."""
        self._turn_at((STICK_RAD_S * pitch, STICK_RAD_S * yaw))

    def _turn_at(self, rates_rad_s: tuple[float, float]) -> None:
        if not self.camera:
            return
        if not any(self._rates_rad_s):
            self._wanted_rad, self._turned_s = self.angles_rad, math.nan
        self._rates_rad_s, self._rates_end_s = rates_rad_s, time.monotonic() + RATE_LASTS_S

    def follow(self, state: State) -> None:
        """Continue turning at the current rate, until it expires without a new command."""
        if not any(self._rates_rad_s):
            return
        since_s = 0.0 if math.isnan(self._turned_s) else max(state.time_s - self._turned_s, 0.0)
        self._turned_s = state.time_s
        limits = (self._pitch_limits_rad, self._yaw_limits_rad)
        pitch, yaw = (
            min(max(angle + rate * since_s, low), high)
            for angle, rate, (low, high) in zip(self._wanted_rad, self._rates_rad_s, limits, strict=True)
        )
        self._wanted_rad = pitch, yaw
        if time.monotonic() > self._rates_end_s:
            self._rates_rad_s = (0.0, 0.0)
        if since_s > 0:
            try:
                self._command(pitch, yaw)
            except ValueError as error:  # the station's pilot has taken the controls
                self._rates_rad_s = (0.0, 0.0)
                self._craft.send_text(str(error))

    def _on_mount_mode(self, given: Given) -> int:
        """Accept any of the modes, since each DO_MOUNT_CONTROL states its own, and no stabilisation."""
        given.integer(1, 0, MOUNT_MODES - 1)
        for index in (2, 3, 4):
            given.switch(index)
        return DONE

    def _on_mount(self, given: Given) -> int:
        mode = given.integer(7, 0, MOUNT_MODES - 1)
        if mode in (MOUNT_RETRACT, MOUNT_NEUTRAL):
            self.centre()
            return DONE
        if mode != MOUNT_TARGETING:
            return UNSUPPORTED
        pitch, _, yaw = (math.radians(given.real(index)) for index in (1, 2, 3))
        self.turn_to(pitch, yaw if self._can_turn(self._yaw_limits_rad) else math.nan)
        return DONE

    def _on_pitch_yaw(self, given: Given) -> int:
        given.integer(7, 0, DEVICE)
        pitch, yaw, pitch_rate, yaw_rate = (math.radians(given.real(index, may_be_nan=True)) for index in (1, 2, 3, 4))
        return self._set(given.sender, given.integer(5, 0, 2**32 - 1), (pitch, yaw), (pitch_rate, yaw_rate))

    def on_gimbal_manager_set_pitchyaw(self, peer: Address, message: Any) -> None:
        """Turn to angles or at rates. The message is not acknowledged."""
        if self.camera and message.gimbal_device_id in (0, DEVICE):
            sender = message.get_srcSystem(), message.get_srcComponent()
            angles, rates = (message.pitch, message.yaw), (message.pitch_rate, message.yaw_rate)
            self._set(sender, message.flags, angles, rates)

    def on_gimbal_manager_set_attitude(self, peer: Address, message: Any) -> None:
        """Turn to the attitude in a quaternion, or at rates. The message is not acknowledged."""
        if not self.camera or message.gimbal_device_id not in (0, DEVICE):
            return
        w, x, y, z = message.q
        angles = math.nan, math.nan
        if not all(math.isnan(part) for part in (w, x, y, z)):
            if not abs(math.hypot(w, x, y, z) - 1) <= 0.01:
                raise ValueError(f"gimbal: q = {list(message.q)}: must have the length 1, or be NaN")
            sine = max(-1.0, min(2 * (w * y - z * x), 1.0))
            angles = math.asin(sine), math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        sender = message.get_srcSystem(), message.get_srcComponent()
        self._set(sender, message.flags, angles, (message.angular_velocity_y, message.angular_velocity_z))

    def _set(
        self, sender: tuple[int, int], flags: int, angles_rad: tuple[float, float], rates_rad_s: tuple[float, float]
    ) -> int:
        if self._owner not in ((0, 0), sender):
            self._craft.send_text(f"gimbal: system {self._owner[0]} is in control")
            return DENIED
        if any(math.isinf(value) for value in (*angles_rad, *rates_rad_s)):
            raise ValueError(f"gimbal: {[*angles_rad, *rates_rad_s]} rad, rad/s: must be numbers, or NaN")
        if flags & (YAW_LOCK | YAW_IN_EARTH):
            raise ValueError("gimbal: yaw: must be relative to the vehicle: no yaw lock, no earth frame")
        if flags & (RETRACT | NEUTRAL):
            self.centre()
        elif all(math.isnan(angle) for angle in angles_rad):
            self._turn_at(tuple(0.0 if math.isnan(rate) else rate for rate in rates_rad_s))  # type: ignore[arg-type]
        else:
            yaw_rad = angles_rad[1]
            if yaw_rad == 0 and not self._can_turn(self._yaw_limits_rad):
                yaw_rad = math.nan
            self.turn_to(angles_rad[0], yaw_rad)
        return DONE

    def _on_configure(self, given: Given) -> int:
        system, component = given.integer(1, RELEASE, 255), given.integer(2, RELEASE, 255)
        given.integer(7, 0, DEVICE)
        if system == MINE:
            self._owner = given.sender
        elif system == RELEASE:
            self._owner = (0, 0) if self._owner == given.sender else self._owner
        elif system >= 0:
            if component < 0:
                raise given.denied(2, "a component in [0, 255] with a system")
            self._owner = system, component
        given.replies.append(self.status())
        return DONE
