"""A pilot's sticks and buttons: MANUAL_CONTROL and RC_CHANNELS_OVERRIDE, as ArduSub reads them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.endpoint import Peer
from uwsim.bridges.mavlink.flight import Flight
from uwsim.bridges.mavlink.gimbal import Gimbal
from uwsim.bridges.mavlink.modes import ALT_HOLD, AUTO, GUIDED, MANUAL, POSHOLD, STABILIZE, SURFTRAK

FULL, NEUTRAL_THROTTLE = 1000, 500
BUTTONS = 16
DEFAULT_FUNCTIONS = (0, 5, 7, 6, 4, 1, 3, 21, 48, 23, 22, 42, 43, 33, 32, 0)
"""Functions of buttons 0 to 15 (AP_JSButton.h), as in ArduSub's default_js_buttons."""
RC_AXES = (("pitch", -1), ("roll", 1), ("heave", 1), ("yaw", -1), ("surge", 1), ("sway", -1))
"""Efforts of RC channels 1 to 6."""
RC_PAN, RC_TILT, RC_LIGHTS = 7, 8, 9
NEUTRAL_US, SPAN_US, LIGHTS_OFF_US = 1500, 400, 1100
RC_RANGE_US = (800, 2200)
IGNORED = 0xFFFF
RELEASED = {0, 0xFFFE}


class Sticks:
    """Converts sticks to efforts, and buttons and channels to changes of mode, camera tilt and lights.

    functions: the function of each button, as parameters BTN0_FUNCTION to BTN15_FUNCTION. apply: applies efforts
    through a channel, which ends them if no more stick messages arrive; None if the vehicle cannot be steered.
    """

    def __init__(
        self, craft: Craft, flight: Flight, gimbal: Gimbal, apply: Callable[[Mapping[str, float]], None] | None
    ) -> None:
        self._craft, self._flight, self._gimbal, self._apply = craft, flight, gimbal, apply
        self.functions = {f"BTN{k}_FUNCTION": number for k, number in enumerate(DEFAULT_FUNCTIONS)}
        self._pressed = 0
        self._pulses_us: dict[int, int] = {}
        self._pressing: dict[int, Callable[[], object]] = {
            2: lambda: flight.disarm() if flight.is_armed else flight.arm(),
            3: flight.arm,
            4: flight.disarm,
            **{function: partial(flight.set_mode, mode) for function, mode in MODE_FUNCTIONS.items()},
            21: gimbal.centre,
            31: lambda: self.light(not self.is_lit),
            32: lambda: self.light(True),
            33: lambda: self.light(False),
        }
        self._holding: dict[int, tuple[float, float]] = {
            22: (1.0, 0.0),
            23: (-1.0, 0.0),
            26: (0.0, 1.0),
            27: (0.0, -1.0),
        }

    @property
    def is_lit(self) -> bool:
        """True if any lamp is on."""
        return any(lamp.on for lamp in self._craft.vehicle.lamps.values())

    def light(self, on: bool) -> None:
        """Switch all lamps."""
        for name, lamp in self._craft.vehicle.lamps.items():
            if lamp.on != on:
                self._craft.command("set_lamp", lamp=name, on=on)

    def on_manual_control(self, peer: Peer, message: Any) -> None:
        """Set efforts (positive: forward, right, up, clockwise), and execute the functions of the buttons."""
        self._obey_buttons(message.buttons)
        if not self._flight.is_by_sticks or self._apply is None:
            return
        names = "xyzr" + "s" * (message.enabled_extensions & 1) + "t" * (message.enabled_extensions >> 1 & 1)
        axes = {name: getattr(message, name) for name in names}
        if any(not -FULL <= value <= FULL for value in axes.values()):
            raise ValueError(f"MANUAL_CONTROL: {axes}: must be in [{-FULL}, {FULL}]")
        heave = max(-1.0, min((axes["z"] - NEUTRAL_THROTTLE) / NEUTRAL_THROTTLE, 1.0))
        efforts = {"surge": axes["x"] / FULL, "sway": -axes["y"] / FULL, "heave": heave, "yaw": -axes["r"] / FULL}
        self._apply({**efforts, "pitch": -axes.get("s", 0) / FULL, "roll": axes.get("t", 0) / FULL})

    def _obey_buttons(self, buttons: int) -> None:
        new, self._pressed = buttons & ~self._pressed, buttons
        pitch = yaw = 0.0
        is_turning = False
        for k in range(BUTTONS):
            function = self.functions[f"BTN{k}_FUNCTION"]
            if buttons >> k & 1 and function in self._holding:
                by_pitch, by_yaw = self._holding[function]
                pitch, yaw, is_turning = pitch + by_pitch, yaw + by_yaw, True
            if new >> k & 1 and function in self._pressing:
                self._pressing[function]()
        if is_turning:
            self._gimbal.turn_by_stick(pitch, yaw)

    def on_rc_channels_override(self, peer: Peer, message: Any) -> None:
        """Apply RC channels 1 to 9 [us]: pitch, roll, throttle, yaw, forward, lateral, camera pan and tilt, lights.

        0 releases a channel, and 65535 leaves it unchanged. Above channel 8, 65534 releases it, and 0 leaves it
        unchanged.
        """
        for k in range(1, 10):
            pulse_us = getattr(message, f"chan{k}_raw")
            if pulse_us == IGNORED or (k > 8 and pulse_us == 0):
                continue
            if pulse_us in RELEASED:
                self._pulses_us.pop(k, None)
            elif RC_RANGE_US[0] <= pulse_us <= RC_RANGE_US[1]:
                self._pulses_us[k] = pulse_us
            else:
                raise ValueError(
                    f"RC_CHANNELS_OVERRIDE: chan{k}_raw = {pulse_us} us: must be in {list(RC_RANGE_US)}, or 0"
                )
        if {RC_PAN, RC_TILT} & self._pulses_us.keys():
            self._gimbal.turn_by_stick(self._deflection(RC_TILT), self._deflection(RC_PAN))
        if RC_LIGHTS in self._pulses_us:
            self.light(self._pulses_us[RC_LIGHTS] > LIGHTS_OFF_US)
        if self._flight.is_by_sticks and self._apply is not None:
            self._apply({axis: sign * self._deflection(k) for k, (axis, sign) in enumerate(RC_AXES, start=1)})

    def _deflection(self, channel: int) -> float:
        return max(-1.0, min((self._pulses_us.get(channel, NEUTRAL_US) - NEUTRAL_US) / SPAN_US, 1.0))


MODE_FUNCTIONS = {5: MANUAL, 6: STABILIZE, 7: ALT_HOLD, 8: POSHOLD, 9: AUTO, 11: GUIDED, 13: SURFTRAK}
