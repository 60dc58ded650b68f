"""A pilot's sticks and buttons: MANUAL_CONTROL and RC_CHANNELS_OVERRIDE, as ArduSub reads them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.component import INFO_TEXT
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.flight import Flight
from uwsim.bridges.mavlink.gimbal import Gimbal
from uwsim.bridges.mavlink.modes import ALT_HOLD, AUTO, GUIDED, MANUAL, POSHOLD, STABILIZE, SURFACE, SURFTRAK
from uwsim.bridges.mavlink.settings import Settings
from uwsim.bridges.mavlink.stations import Sender, Stations, sender_of

FULL, NEUTRAL_THROTTLE = 1000, 500
BUTTONS = 16
RC_AXES = (("pitch", -1), ("roll", 1), ("heave", 1), ("yaw", -1), ("surge", 1), ("sway", -1))
"""Efforts of RC channels 1 to 6."""
RC_PAN, RC_TILT, RC_LIGHTS = 7, 8, 9
NEUTRAL_US, SPAN_US, LIGHTS_OFF_US = 1500, 400, 1100
RC_RANGE_US = (800, 2200)
INVALID = 0x7FFF
"""The value of an axis of MANUAL_CONTROL that is not given."""
IGNORED = 0xFFFF
RELEASED = {0, 0xFFFE}


class Sticks:
    """Converts sticks to efforts, and buttons and channels to changes of mode, camera tilt and lights.

    Only the station that owns the sticks may use them; see Stations. settings: the buttons' functions, and the gain,
    by which ArduSub multiplies MANUAL_CONTROL. apply: applies efforts through a channel, which ends them if no more
    stick messages arrive; None if the vehicle cannot be steered.
    """

    def __init__(
        self,
        craft: Craft,
        flight: Flight,
        gimbal: Gimbal,
        stations: Stations,
        settings: Settings,
        apply: Callable[[Mapping[str, float]], None] | None,
    ) -> None:
        self._craft, self._flight, self._gimbal, self._apply = craft, flight, gimbal, apply
        self._stations, self._settings = stations, settings
        craft.gain = settings["JS_GAIN_DEFAULT"]
        self._pressed = 0
        self._refused = ""
        self._sender: Sender = (0, 0)
        self._pulses_us: dict[int, int] = {}
        self._pressing: dict[int, Callable[[], object]] = {
            2: lambda: flight.disarm() if flight.is_armed else flight.arm(self._sender),
            3: lambda: flight.arm(self._sender),
            4: flight.disarm,
            **{function: partial(flight.set_mode, mode) for function, mode in MODE_FUNCTIONS.items()},
            21: gimbal.centre,
            31: lambda: self.light(not self.is_lit),
            32: lambda: self.light(True),
            33: lambda: self.light(False),
            41: lambda: self._set_gain(1.0 if craft.gain == 0.5 else 0.5),
            42: lambda: self._change_gain(1),
            43: lambda: self._change_gain(-1),
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

    def on_manual_control(self, peer: Address, message: Any) -> None:
        """Set efforts (positive: forward, right, up, clockwise), and execute the functions of the buttons."""
        if not self._may_use(message):
            return
        self._obey_buttons(message.buttons)
        if not self._flight.is_by_sticks or self._apply is None:
            return
        names = "xyzr" + "s" * (message.enabled_extensions & 1) + "t" * (message.enabled_extensions >> 1 & 1)
        axes = {name: getattr(message, name) for name in names}
        axes |= {name: NEUTRAL_THROTTLE if name == "z" else 0 for name in axes if axes[name] == INVALID}
        if any(abs(value) > FULL for value in axes.values()):
            wrong = ", ".join(f"{name} = {value}" for name, value in axes.items() if abs(value) > FULL)
            self._refuse(f"MANUAL_CONTROL: {wrong}: must be in [{-FULL}, {FULL}], or {INVALID} for none")
            return
        self._refused = ""
        heave = (axes["z"] - NEUTRAL_THROTTLE) / NEUTRAL_THROTTLE * self._settings["JS_THR_GAIN"]
        efforts = {"surge": axes["x"] / FULL, "sway": -axes["y"] / FULL, "heave": heave, "yaw": -axes["r"] / FULL}
        efforts |= {"pitch": -axes.get("s", 0) / FULL, "roll": axes.get("t", 0) / FULL}
        efforts = {axis: max(-1.0, min(self._craft.gain * effort, 1.0)) for axis, effort in efforts.items()}
        self._craft.channels_us = {
            k: round(NEUTRAL_US + sign * SPAN_US * efforts[axis]) for k, (axis, sign) in enumerate(RC_AXES, start=1)
        }
        self._apply(efforts)

    def _refuse(self, reason: str) -> None:
        """Raise ValueError, once for a run of messages with the same fault: they come 20 times per second."""
        is_new, self._refused = reason != self._refused, reason
        if is_new:
            raise ValueError(reason)

    def _may_use(self, message: Any) -> bool:
        """Return whether the sender has the sticks, or the vehicle is not armed."""
        self._sender = sender_of(message)
        return not self._flight.is_armed or self._stations.require(self._sender, message.get_type())

    def _change_gain(self, steps: int) -> None:
        low, high, count = (self._settings[f"JS_GAIN_{name}"] for name in ("MIN", "MAX", "STEPS"))
        step = (high - low) / (count - 1) if count > 1 else 0.0
        gain = self._craft.gain + steps * step if step else self._settings["JS_GAIN_DEFAULT"]
        self._set_gain(max(low, min(gain, high)))

    def _set_gain(self, gain: float) -> None:
        self._craft.gain = gain
        self._craft.send_text(f"#Gain is {100 * gain:.0f}%", INFO_TEXT)

    def _obey_buttons(self, buttons: int) -> None:
        new, self._pressed = buttons & ~self._pressed, buttons
        pitch = yaw = 0.0
        is_turning = False
        for k in range(BUTTONS):
            function = int(self._settings[f"BTN{k}_FUNCTION"])
            if buttons >> k & 1 and function in self._holding:
                by_pitch, by_yaw = self._holding[function]
                pitch, yaw, is_turning = pitch + by_pitch, yaw + by_yaw, True
            if new >> k & 1 and function in self._pressing:
                self._pressing[function]()
        if is_turning:
            self._gimbal.turn_by_stick(pitch, yaw)

    def on_rc_channels_override(self, peer: Address, message: Any) -> None:
        """Apply RC channels 1 to 9 [us]: pitch, roll, throttle, yaw, forward, lateral, camera pan and tilt, lights.

        0 releases a channel, and 65535 leaves it unchanged. Above channel 8, 65534 releases it, and 0 leaves it
        unchanged.
        """
        if not self._may_use(message):
            return
        for k in range(1, 10):
            pulse_us = getattr(message, f"chan{k}_raw")
            if pulse_us == IGNORED or (k > 8 and pulse_us == 0):
                continue
            if pulse_us in RELEASED:
                self._pulses_us.pop(k, None)
            elif RC_RANGE_US[0] <= pulse_us <= RC_RANGE_US[1]:
                self._pulses_us[k] = pulse_us
            else:
                self._refuse(f"RC_CHANNELS_OVERRIDE: chan{k}_raw = {pulse_us} us: must be in {list(RC_RANGE_US)}, or 0")
                return
        self._refused = ""
        self._craft.channels_us = dict(self._pulses_us)
        if {RC_PAN, RC_TILT} & self._pulses_us.keys():
            self._gimbal.turn_by_stick(self._deflection(RC_TILT), self._deflection(RC_PAN))
        if RC_LIGHTS in self._pulses_us:
            self.light(self._pulses_us[RC_LIGHTS] > LIGHTS_OFF_US)
        if self._flight.is_by_sticks and self._apply is not None:
            self._apply({axis: sign * self._deflection(k) for k, (axis, sign) in enumerate(RC_AXES, start=1)})

    def _deflection(self, channel: int) -> float:
        return max(-1.0, min((self._pulses_us.get(channel, NEUTRAL_US) - NEUTRAL_US) / SPAN_US, 1.0))


MODE_FUNCTIONS = {5: MANUAL, 6: STABILIZE, 7: ALT_HOLD, 8: POSHOLD, 9: AUTO, 11: GUIDED, 12: SURFACE, 13: SURFTRAK}
