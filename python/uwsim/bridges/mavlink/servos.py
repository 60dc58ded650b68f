"""The vehicle's servo outputs: thrusters first, then lights and camera tilt where the BlueROV2 has them."""

from __future__ import annotations

from collections.abc import Mapping

from uwsim.bridges.mavlink.component import DONE, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.gimbal import Gimbal
from uwsim.bridges.mavlink.telemetry import FULL_US, LIGHTS, OFF_US, TILT

PULSE_US = (800, 2200)


class Servos:
    """Sets lights and camera tilt by pulses, as ArduPilot's DO_SET_SERVO does. Motors cannot be set, as there."""

    def __init__(self, craft: Craft, gimbal: Gimbal) -> None:
        self._craft, self._gimbal = craft, gimbal

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD."""
        return {183: self._on_set_servo}

    def _on_set_servo(self, given: Given) -> int:
        output, pulse_us = given.integer(1), given.integer(2)
        if why := self.refusal(output, pulse_us):
            raise given.denied(*why)
        self.set(output, pulse_us)
        return DONE

    def refusal(self, output: float, pulse_us: float) -> tuple[int, str] | None:
        """Return the parameter, 1 or 2, that cannot be obeyed, and the rule that it breaks; None if it can be."""
        outputs = {LIGHTS: "lights"} if self._craft.vehicle.lamps else {}
        outputs |= {TILT: "camera tilt"} if self._gimbal.camera else {}
        if output not in outputs:
            return 1, " or ".join(f"{k} ({name})" for k, name in outputs.items()) or "an output: it has none"
        low, high = PULSE_US
        return None if low <= pulse_us <= high else (2, f"in [{low}, {high}] us")

    def set(self, output: int, pulse_us: float) -> None:
        """Set an output, from any thread, without waiting. Raises ValueError while others steer."""
        if output == TILT:
            self._gimbal.turn_to_share((pulse_us - OFF_US) / (2 * FULL_US))
            return
        for name in self._craft.vehicle.lamps:
            self._craft.send("set_lamp", lamp=name, on=pulse_us > OFF_US)
