"""Parts of a scenario's water: the state of a sample (EOS-80), tides, wind, and targets that only sonars detect."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal, NamedTuple, TypeVar

from pydantic import AfterValidator, Field

from uwsim import _core
from uwsim.scenario.spec.fields import Degrees, InRange, Model, Name, Point3, broken

TOLERANCE_KG_M3 = 5.0
"""Largest accepted difference between a specified density and that derived from temperature and salinity. Fresh water
rounded to 1000 kg/m3 is off by up to 4.4 from 0 to 30 deg C, sea water of 35 psu rounded to 1025 by up to 3.3, and a
density measured in place 1 km down by 4.6. Sea water mistaken for fresh water is off by 26."""
SALTIEST_PSU = 45.0
DEEPEST_M = 12_000.0
_PA_PER_M = 1e4


class WaterState(NamedTuple):
    """The properties of a body of water as specified in a scenario. density_kg_m3, salinity_psu: None if derived.

    temperatures_deg_c: temperatures at its upper and lower end. depth_m: depth at which the density may have been
    measured; 0 for densities at atmospheric pressure.
    """

    density_kg_m3: float | None
    salinity_psu: float | None
    temperatures_deg_c: tuple[float, ...]
    depth_m: float = 0.0

    @property
    def salinity(self) -> float:
        """The salinity [psu] as specified, else 0 if the density matches fresh water, else derived from the density."""
        if self.salinity_psu is not None:
            return self.salinity_psu
        if self.density_kg_m3 is None or self.density_kg_m3 <= self._at_top(0.0) + TOLERANCE_KG_M3:
            return 0.0
        low, high = 0.0, SALTIEST_PSU
        while high - low > 1e-9:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._at_top(middle) < self.density_kg_m3 else (low, middle)
        return high

    @property
    def density(self) -> float:
        """The specified density, else the density at the first temperature and the salinity [kg/m3]."""
        return self._at_top(self.salinity) if self.density_kg_m3 is None else self.density_kg_m3

    @property
    def broken_rule(self) -> str:
        """The rule broken by the density at the specified salinity, or an empty string."""
        if self.density_kg_m3 is None or self.salinity_psu is None:
            return ""
        low, high = self._density_of(self.salinity_psu)
        if low - TOLERANCE_KG_M3 <= self.density_kg_m3 <= high + TOLERANCE_KG_M3:
            return ""
        return (
            f"must be within {TOLERANCE_KG_M3:g} kg/m3 of {_span(low, high)} kg/m3, which salinity_psu = "
            f"{self.salinity_psu:g} psu gives at {_span(*sorted(self.temperatures_deg_c))} deg C; leave one of them out"
        )

    def _at_top(self, salinity_psu: float) -> float:
        return _core.sea_water_density_kg_m3(self.temperatures_deg_c[0], salinity_psu)

    def _density_of(self, salinity_psu: float) -> tuple[float, float]:
        """Return the smallest density of water of this salinity, and the largest, which occurs under pressure."""
        pressure_pa = _PA_PER_M * self.depth_m
        return (
            min(_core.sea_water_density_kg_m3(t, salinity_psu) for t in self.temperatures_deg_c),
            max(_core.sea_water_density_kg_m3(t, salinity_psu, pressure_pa) for t in self.temperatures_deg_c),
        )


def _span(*ends: float) -> str:
    low, high = f"{ends[0]:.5g}", f"{ends[-1]:.5g}"
    return low if low == high else f"{low} to {high}"


def _is_time(text: str) -> str:
    try:
        year = datetime.fromisoformat(text).year
    except ValueError:
        year = 0
    if not 1900 <= year <= 2100:
        raise broken("must be a time in quotes, as '2026-05-01T06:00:00Z', from 1900 to 2100", value=text[:40])
    return text


WORLD_BEGIN = "2020-01-01T00:00:00Z"
"""The time at which worlds begin, in survey files, too."""
Begin = Annotated[str, AfterValidator(_is_time)]

Constituent = Literal[
    "M2", "S2", "N2", "K2", "K1", "O1", "P1", "Q1", "M4", "MS4", "MN4", "M6", "M8", "S4", "S6", "MK3", "2MK3", "2SM2",
    "M3", "2N2", "MU2", "NU2", "LAM2", "L2", "T2", "R2", "J1", "OO1", "2Q1", "RHO", "MM", "MF", "MSF", "SSA",
]  # fmt: skip
"""NOAA's names."""


class TideConstituent(Model):
    """A constituent of the tide's height.

    constituent: M2, S2, K1, O1 or another by its name in NOAA's tables. amplitude_m, phase_deg: its harmonic constants;
    the phase is the Greenwich lag.
    """

    constituent: Constituent
    amplitude_m: Annotated[float, InRange(0, 10, "m")]
    phase_deg: Degrees = 0.0


class Tide(Model):
    """The height of the sea above z = 0, the same in the whole world.

    constituents: add up, with the nodal corrections at the beginning. begin: time of the world's beginning [UTC, ISO
    8601].
    """

    constituents: tuple[TideConstituent, ...] = Field(
        min_length=1, max_length=40, examples=[[{"constituent": "M2", "amplitude_m": 1}]]
    )
    begin: Begin = WORLD_BEGIN


PartT = TypeVar("PartT", bound=Model)
OPTICS_MOST_M_S, LINK_MOST_M_S = 14.0, 40.0
"""The strongest wind in the models of ripples and of noise."""
Area = Annotated[float, InRange(0, 1e5, "m2")]


class Wind(Model):
    """The wind over the water, which pushes vehicles with a `windage`, ripples the surface and is heard by modems.

    speed_m_s: mean over an hour, 10 m above the water. heading_deg: direction towards which it blows, counter-clockwise
    from east. gusts: along the wind, by a spectrum: `npd`, ISO 19901-1 (2005, A.7.4; the Norwegian Petroleum
    Directorate's); `davenport`, Davenport 1961 (Q. J. R. Meteorol. Soc. 87:194) with the drag coefficient
    surface_drag; by default none. They depend on the scenario's seed alone. surface_drag: of the sea, 0.001 to 0.003,
    for `davenport`. Waves are `water.surface`. The optics and the link have this wind unless they have their own.
    """

    speed_m_s: Annotated[float, InRange(0, 60, "m/s")] = Field(examples=[5])
    heading_deg: Degrees = 20.0
    gusts: Literal["npd", "davenport"] | None = None
    surface_drag: Annotated[float, InRange(0.0005, 0.01)] = 0.0015


def in_wind(part: PartT, limit_m_s: float, wind: Wind) -> PartT:
    """Return a copy of optics or a link with this wind, where its own is not given; up to the speed of its model."""
    own = {"wind_m_s": min(wind.speed_m_s, limit_m_s), "wind_heading_deg": wind.heading_deg}
    update = {key: value for key, value in own.items() if key in type(part).model_fields.keys() - part.model_fields_set}
    given = part.model_fields_set
    return type(part).model_construct(_fields_set=given, **{**part.__dict__, **update})


class Windage(Model):
    """A floating hull in the wind, symmetric fore and aft: its forces.

    By Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion Control", sec. 8.1.
    frontal_area_m2, lateral_area_m2: above the water, seen from ahead and from abeam. length_m: overall. height_m: of
    their centre above the body's origin. surge, sway, yaw: coefficients c_x, c_y, c_n; experiments gave 0.5 to 0.9, 0.7
    to 0.95 and 0.05 to 0.2. They shrink as the hull dives.
    """

    frontal_area_m2: Area
    lateral_area_m2: Area
    length_m: Annotated[float, InRange(0.01, 500, "m")]
    height_m: Annotated[float, InRange(0.01, 100, "m")]
    surge: Annotated[float, InRange(0, 2)] = 0.7
    sway: Annotated[float, InRange(0, 2)] = 0.8
    yaw: Annotated[float, InRange(0, 1)] = 0.1


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
