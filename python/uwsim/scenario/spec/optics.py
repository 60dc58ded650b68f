"""The optical conditions of a scenario: water, also by its visibility, sun, wind over the surface, particles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypedDict

from pydantic import BeforeValidator, model_validator

from uwsim import _core
from uwsim.scenario.spec.fields import Degrees, InRange, Model, OneOf, broken
from uwsim.scenario.spec.water_parts import OPTICS_MOST_M_S


def visibility_m(water: _core.WaterOptics) -> float:
    """Return the distance at which a diver can see a dark object horizontally: 4.8 / c, with c [1/m] at 550 nm.

    Zaneveld and Pegau 2003, "Robust underwater visibility parameter", Optics Express 11, which gives the factor for 532
    nm.
    """
    return 4.8 / float(water.beam_attenuation[1])


def scaled_to(visibility: float | None, water: _core.WaterOptics) -> _core.WaterOptics:
    """Return the water with all coefficients scaled alike to a visibility [m], or itself for None.

    Raises ValueError if a coefficient would leave the core's range.
    """
    if visibility is None:
        return water
    share = visibility_m(water) / visibility
    return _core.WaterOptics(share * water.diffuse_attenuation, share * water.absorption, share * water.scattering)


PerMetre = Annotated[float, InRange(1e-4, 100, "1/m")]
PerBand = tuple[PerMetre, PerMetre, PerMetre]


class WaterCoefficients(Model):
    """Custom water, for red (600 nm), green (550 nm) and blue (450 nm).

    diffuse_attenuation: Kd of daylight. absorption, scattering: coefficients of the water.
    """

    diffuse_attenuation: PerBand
    absorption: PerBand
    scattering: PerBand

    @model_validator(mode="after")
    def _absorbs_at_most_what_is_lost(self) -> WaterCoefficients:
        """Check that Kd is at least a, since light that has descended a metre has travelled at least a metre."""
        for band, (a, kd) in enumerate(zip(self.absorption, self.diffuse_attenuation, strict=True)):
            if a > kd:
                rule = f"must be at most diffuse_attenuation[{band}] = {kd:g} 1/m: light that descends a metre has gone"
                raise broken(rule + " at least that", at=("absorption", band), value=a, unit="1/m")
        return self


def _jerlov(value: object) -> object:
    if not isinstance(value, str):
        raise broken(f"must be one of {', '.join(_core.jerlov_types())}")
    return value


class OpticsChanges(TypedDict, total=False):
    """The fields of Optics as keyword arguments."""

    jerlov: str
    coefficients: WaterCoefficients | Mapping[str, Any] | None
    visibility_m: float | None
    sun_elevation_deg: float
    sun_azimuth_deg: float
    wind_m_s: float
    wind_heading_deg: float
    fetch_m: float | None
    particles_per_m3: float
    turbulence_k: float


class Optics(Model):
    """The optical conditions for cameras.

    jerlov: the water type, unless coefficients are given. coefficients: custom optical properties of the water.
    visibility_m: the distance at which a diver sees a dark object, against turbidity: it scales all coefficients alike,
    which keeps the water's colour; by default that of the water type or the coefficients. sun_elevation_deg: above the
    horizon. sun_azimuth_deg: direction towards the sun, counter-clockwise from east. wind_m_s, wind_heading_deg: speed
    and direction of the breeze that ripples the surface, by default that of `wind`, if there is one; the
    ripples only refract light: vehicles feel the waves of `water.surface`. fetch_m: the length of water over which that
    wind has blown: longer waves than it raises over it (JONSWAP) are absent; by default waves of all lengths come from
    afar. particles_per_m3: density of particles large enough to be individually visible. turbulence_k: standard
    deviation of the temperature in the eddies that refract light (effect `wobble`): 0 in water at rest, 0.1 in calm
    water, 2 where warm and cold water mix; assumed.
    """

    jerlov: Annotated[str, BeforeValidator(_jerlov), OneOf(tuple(_core.jerlov_types()))] = "III"
    coefficients: WaterCoefficients | None = None
    visibility_m: Annotated[float, InRange(0.1, 1000, "m")] | None = None
    sun_elevation_deg: Annotated[float, InRange(-6, 90, "deg")] = 55.0
    sun_azimuth_deg: Degrees = 120.0
    wind_m_s: Annotated[float, InRange(0, OPTICS_MOST_M_S, "m/s")] = 3.0
    wind_heading_deg: Degrees = 20.0
    fetch_m: Annotated[float, InRange(1, 1e6, "m")] | None = None
    particles_per_m3: Annotated[float, InRange(0, 64, "1/m3")] = 20.0
    turbulence_k: Annotated[float, InRange(0, 20, "K")] = 2.0

    @property
    def water(self) -> _core.WaterOptics:
        """The optical properties of the water, scaled to the visibility that is set, if one is."""
        own = self.coefficients
        if own is None:
            return scaled_to(self.visibility_m, _core.WaterOptics.jerlov(self.jerlov))
        return scaled_to(self.visibility_m, _core.WaterOptics(own.diffuse_attenuation, own.absorption, own.scattering))

    @model_validator(mode="after")
    def _water_can_be_that_turbid(self) -> Optics:
        if self.visibility_m is not None:
            try:
                _ = self.water
            except ValueError as error:
                rule = f"impossible in this water: {error}"
                raise broken(rule, at=("visibility_m",), value=self.visibility_m, unit="m") from None
        return self

    def with_changes(self, changes: Mapping[str, Any]) -> Optics:
        """Return a validated copy with some fields replaced. Raises ScenarioError."""
        from uwsim.scenario.read.validated import validated

        return validated(Optics, {**{key: getattr(self, key) for key in type(self).model_fields}, **changes})
