"""Targets in the water that only sonars detect: schools of fish and the bubbles of seeps, as points."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from uwsim.scenario.spec.fields import InRange, Model, Name, Point3

TargetStrength = Annotated[float, InRange(-120, 40, "dB")]
TargetCount = Annotated[int, InRange(1, 10_000)]
TargetSize = Annotated[float, InRange(0.001, 10_000, "m")]


class School(Model):
    """A school of fish, which stands still.

    position_m: its middle. size_m: diameters of the ellipsoid that it fills evenly. count: number of fish.
    target_strength_db: target strength of each fish, re 1 m2; the default is that of a fish of 30 cm, rounded:
    20 log10 L - 67.4 with the length L in cm is -37.9 dB (Foote 1987, J. Acoust. Soc. Am. 82:981, for physoclists such
    as cod from above at 38 kHz).
    """

    kind: Literal["school"]
    name: Name
    position_m: Point3
    size_m: tuple[TargetSize, TargetSize, TargetSize]
    count: TargetCount = 100
    target_strength_db: TargetStrength = -38.0


class Seep(Model):
    """A plume of bubbles that rise from a source; a bubble that reaches the top starts again at the source.

    position_m: the source. height_m, top_diameter_m: size of the cone that the plume fills. count: number of bubbles.
    target_strength_db: target strength of each bubble, re 1 m2; by default a^2 / 4 for a radius a of 2 mm, the
    geometric cross-section of a bubble that is large compared with the wavelength. rise_m_s: speed; the default is
    typical for that size (both assumed).
    """

    kind: Literal["seep"]
    name: Name
    position_m: Point3
    height_m: TargetSize
    top_diameter_m: TargetSize = 1.0
    count: TargetCount = 500
    target_strength_db: TargetStrength = -60.0
    rise_m_s: Annotated[float, InRange(0, 10, "m/s")] = 0.25


WaterTargetSpec = Annotated[School | Seep, Field(discriminator="kind")]
