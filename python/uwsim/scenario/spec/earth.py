"""The place on Earth of a scenario's world."""

from __future__ import annotations

from typing import Annotated

from uwsim.scenario.spec.fields import InRange, Model


class Earth(Model):
    """The location of the world's origin on Earth, where x points to the east and y to true north (WGS 84).

    Elsewhere, x and y are those of the transverse Mercator projection about the origin.
    latitude_deg: geodetic latitude, north positive, which decides gravity, too (WGS 84). longitude_deg: longitude, east
    positive. magnetic_year: the year (2026.5 is its middle) of the World Magnetic Model whose field at the origin all
    compasses measure, except what their own declination_deg, inclination_deg and field_ut give; by default, only these
    and their defaults count.
    """

    latitude_deg: Annotated[float, InRange(-89, 89, "deg")]
    longitude_deg: Annotated[float, InRange(-180, 180, "deg")]
    magnetic_year: Annotated[float, InRange(2020, 2030, "yr")] | None = None
