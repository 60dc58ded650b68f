"""Lamps and camera mounts on an autopilot's servo outputs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from uwsim.bridges.rare_log import RareLog

if TYPE_CHECKING:
    from uwsim.simulator.vehicle import Vehicle

LIGHTS_OFF_US, LIGHTS_SPAN_US = 1100, 800
CENTRE_US, SPAN_US = 1500, 400
TILT_AT_SPAN_RAD = math.radians(45)
"""ArduSub's camera mount: MNT1_PITCH_MIN and MAX are -45 and 45 degrees, at 1100 and 1900 us; positive is up."""


class Auxiliary:
    """Dims a vehicle's lamps and tilts its cameras as the servo outputs `lights` and `tilt`, numbered from 1, require.

    command: issues a command to the vehicle. set_parameter: sets a parameter of the simulator. Raises ValueError.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        lights: int | None,
        tilt: int | None,
        command: Callable[..., object],
        set_parameter: Callable[[str, float], object],
        log: RareLog,
    ) -> None:
        self._outputs = {"lights": lights, "tilt": tilt}
        for name, output in self._outputs.items():
            if output is not None and not 1 <= output <= 32:
                raise ValueError(f"{name} = {output}: must be the number of a servo output, in [1, 32]")
        self._vehicle, self._command, self._set_parameter, self._log = vehicle, command, set_parameter, log
        self._fluxes_lm = {name: lamp.spec.flux_lm for name, lamp in vehicle.lamps.items()}
        self._set: dict[str, int] = {}
        self._asked: dict[str, int] = {}

    @property
    def watched(self) -> list[int]:
        """The indices of the outputs."""
        return [output - 1 for output in self._outputs.values() if output is not None]

    def ask(self, outputs_us: Sequence[int] | Any) -> None:
        """Take the pulse widths of a frame [us]."""
        self._asked = {
            name: int(outputs_us[output - 1]) for name, output in self._outputs.items() if output is not None
        }

    def apply(self) -> None:
        """Dim lamps and tilt cameras according to the last frame, with effect from the next step."""
        for name, pulse_us in self._asked.items():
            if pulse_us and self._set.get(name) != pulse_us:
                self._set[name] = pulse_us
                (self._dim if name == "lights" else self._tilt)(pulse_us)
        self._asked = {}

    def _dim(self, pulse_us: int) -> None:
        share = min(max((pulse_us - LIGHTS_OFF_US) / LIGHTS_SPAN_US, 0.0), 1.0)
        for lamp, flux_lm in self._fluxes_lm.items():
            self._command("set_lamp", lamp=lamp, on=share > 0)
            if share:
                self._set_parameter(f"{self._vehicle.name}.lamps.{lamp}.flux_lm", share * flux_lm)

    def _tilt(self, pulse_us: int) -> None:
        tilt_rad = -TILT_AT_SPAN_RAD * max(-1.0, min((pulse_us - CENTRE_US) / SPAN_US, 1.0))
        for name, camera in self._vehicle.cameras.items():
            if camera.mount.pan_tilt is None:
                continue
            try:
                self._command("aim_camera", camera=name, tilt_rad=tilt_rad)
            except ValueError as error:  # such as beyond the motor's limits
                self._log.warning(f"ArduSub: {error}")
