"""Pingers, the hydrophones that hear them, and what sound meets in a scenario's water: walls, noise."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import InRange, Model, Name, Point2, Point3, Size, YawPitchRoll, broken
from uwsim.scenario.spec.link import Bottom
from uwsim.scenario.spec.water_parts import LINK_MOST_M_S

Frequency = Annotated[float, InRange(200, 250_000, "Hz")]
Coefficient = Annotated[float, InRange(-1, 1)]


class Pinger(Model):
    """A source that emits a tone burst in all directions once per period.

    position_m: its place in the world, under water. level_db: rms level of the burst at 1 m, dB re 1 uPa. frequency_hz:
    of the tone. period_s, pulse_s: from burst to burst, and length of a burst, which rises and falls within three
    cycles (raised cosines, assumed). first_s: simulated time of the first burst.
    """

    name: Name
    position_m: Point3
    frequency_hz: Frequency
    period_s: Annotated[float, InRange(0.05, 1000, "s")] = 2.0
    pulse_s: Annotated[float, InRange(1e-4, 1, "s")] = 0.004
    level_db: Annotated[float, InRange(60, 250, "dB")] = 170.0
    first_s: Annotated[float, InRange(0, 1000, "s")] = 0.0

    @model_validator(mode="after")
    def _has_pauses(self) -> Pinger:
        if self.pulse_s >= self.period_s:
            raise broken(f"must be less than period_s, {self.period_s:g} s", at=("pulse_s",), value=self.pulse_s)
        return self


class Pool(Model):
    """A rectangular pool whose walls, floor and surface reflect the pingers' sound, by image sources.

    size_m: along x and y. centre_m: its middle. depth_m: of the flat floor. walls, floor, surface: reflection
    coefficients of pressure, at all angles; 0.7 is about that of concrete at normal incidence, by the impedances of
    concrete, 8e6 N s/m3 (assumed), and water; that of the surface is negative. order: most reflections of an arrival.
    """

    size_m: tuple[Size, Size]
    centre_m: Point2 = (0.0, 0.0)
    depth_m: Size
    walls: Coefficient = 0.7
    floor: Coefficient = 0.7
    surface: Coefficient = -0.95
    order: Annotated[int, InRange(0, 8)] = 3

    def holds(self, point_m: Point3) -> bool:
        """Return whether a point of the world is in its water."""
        low, high = self.bounds_m()
        return bool(((low <= point_m) & (point_m <= high)).all())

    def bounds_m(self) -> NDArray[np.float64]:
        """Return its lowest and highest corners, (2, 3), in the world."""
        half = 0.5 * np.array(self.size_m)
        centre = np.array(self.centre_m)
        return np.array([[*(centre - half), -self.depth_m], [*(centre + half), 0.0]])


class Sound(Model):
    """The noise that hydrophones have besides the pingers' direct sound.

    pool: reflects the sound; without it, the surface and a flat bed do, at its depth half-way, by the arrivals in
    layered water. bottom: the material of that bed. wind_m_s, shipping: sources of ambient noise, by Wenz's curves; the
    wind by default that of the scenario's `wind`, if there is one; shipping 0: none, 1: heavy.
    """

    pool: Pool | None = None
    bottom: Bottom = "silt"
    wind_m_s: Annotated[float, InRange(0, LINK_MOST_M_S, "m/s")] = 5.0
    shipping: Annotated[float, InRange(0, 1)] = 0.5


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
