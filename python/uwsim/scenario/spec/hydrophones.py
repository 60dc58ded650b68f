"""An array of hydrophones on a vehicle, as read from its YAML file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from uwsim.scenario.spec.fields import InRange, Model, Point3, YawPitchRoll


class HydrophoneArray(Model):
    """One to four hydrophones whose amplifier and converter sample them at the same times.

    position_m, yaw_pitch_roll_deg: the array's frame in the body. phones_m: the hydrophones in that frame; they hear
    alike in all directions. rate_hz: samples per second, of 16 bits. before_s, after_s: the window around each ping,
    from the arrival at the first hydrophone. sensitivity_db: of a hydrophone, dB re 1 V/uPa. gain_db: of the amplifier.
    full_scale_v: at which the converter clips. noise_db: noise of hydrophone and amplifier as sound in the water, dB re
    1 uPa2/Hz, besides the ambient noise; the defaults are assumed.
    """

    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    phones_m: Annotated[tuple[Point3, ...], Field(min_length=1, max_length=4)] = ((0.0, 0.0, 0.0),)
    rate_hz: Annotated[float, InRange(1000, 500_000, "Hz")] = 500_000.0
    before_s: Annotated[float, InRange(0, 0.1, "s")] = 0.001
    after_s: Annotated[float, InRange(1e-4, 0.4, "s")] = 0.008
    sensitivity_db: Annotated[float, InRange(-300, 0, "dB")] = -200.0
    gain_db: Annotated[float, InRange(-60, 120, "dB")] = 40.0
    full_scale_v: Annotated[float, InRange(0.001, 100, "V")] = 2.0
    noise_db: Annotated[float, InRange(-100, 200, "dB")] = 50.0

    @property
    def volts_per_micropascal(self) -> float:
        """The converter's input by the pressure in the water."""
        return float(10.0 ** (0.05 * (self.sensitivity_db + self.gain_db)))
