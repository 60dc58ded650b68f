"""A scenario's water: surface, currents and profile, each selected by `kind`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    StrictBool,
    model_serializer,
    model_validator,
)

from uwsim.scenario.spec.fields import AssetFile, Degrees, InRange, Model, broken
from uwsim.scenario.spec.water_parts import DEEPEST_M, SALTIEST_PSU, WORLD_BEGIN, Begin, Constituent, Tide, WaterState

Celsius = Annotated[float, InRange(-2, 40, "deg C")]
Salinity = Annotated[float, InRange(0, SALTIEST_PSU, "psu")]
Density = Annotated[float, InRange(900, 1100, "kg/m3")]
SoundSpeed = Annotated[float, InRange(1300, 1900, "m/s")]
Depth = Annotated[float, InRange(0, DEEPEST_M, "m")]
ASSUMED_DEG_C = 10.0
"""The temperature for which density, absorption of sound and compression are computed where it is unknown."""
BottomDepth = Annotated[float, InRange(0.1, DEEPEST_M, "m")]
MetresPerSecond = Annotated[float, InRange(-5, 5, "m/s")]
Velocity = tuple[MetresPerSecond, MetresPerSecond, MetresPerSecond]
Deviation = Annotated[float, InRange(0, 5, "m/s")]


class StillSurface(Model):
    """A flat surface at z = 0."""

    kind: Literal["still"] = "still"


class AirySurface(Model):
    """A single linear (Airy) wave.

    amplitude_m, period_s, phase_deg: parameters of the surface's cosine at the origin. heading_deg: direction of
    travel, counter-clockwise from east. depth_m: depth of the water; by default, and at most, that of the terrain's
    deepest point.
    """

    kind: Literal["airy"]
    amplitude_m: Annotated[float, InRange(0, 20, "m")] = Field(examples=[0.3])
    period_s: Annotated[float, InRange(0.2, 60, "s")] = Field(examples=[6])
    heading_deg: Degrees = 0.0
    phase_deg: Degrees = 0.0
    depth_m: BottomDepth | None = None


class JonswapSurface(Model):
    """A random sea with the JONSWAP spectrum, TMA's in finite depth, drawn with the scenario's seed.

    significant_height_m, peak_period_s: parameters of the spectrum. heading_deg: direction of travel, counter-clockwise
    from east. component_count: number of waves that are summed. peak_enhancement: gamma; 1 is a Pierson-Moskowitz sea.
    spreading_exponent: n in cos^n about the heading; 0 for long crests. depth_m: as for an Airy wave.
    """

    kind: Literal["jonswap"]
    significant_height_m: Annotated[float, InRange(0, 20, "m")] = Field(examples=[0.5])
    peak_period_s: Annotated[float, InRange(0.5, 30, "s")] = Field(examples=[6])
    peak_enhancement: Annotated[float, InRange(1, 10)] = 3.3
    heading_deg: Degrees = 0.0
    spreading_exponent: Annotated[float, InRange(0, 100)] = 0.0
    component_count: Annotated[int, InRange(8, 512)] = 64
    depth_m: BottomDepth | None = None


SoundSpeedEquation = Literal["automatic", "unesco", "del_grosso", "belogolskii", "leroy", "mackenzie", "medwin"]
SurfaceSpec = Annotated[StillSurface | AirySurface | JonswapSurface, Field(discriminator="kind")]


class UniformCurrent(Model):
    """A current that is constant in space and time.

    velocity_m_s: components along the world's axes.
    """

    kind: Literal["uniform"]
    velocity_m_s: Velocity


class CurrentLevel(Model):
    """The current at a depth.

    depth_m: depth below the surface. velocity_m_s: components along the world's axes.
    """

    depth_m: Depth
    velocity_m_s: Velocity


def _check_depths_rise(levels: tuple[CurrentLevel, ...] | tuple[WaterLevel, ...]) -> None:
    for index in range(1, len(levels)):
        if levels[index].depth_m <= levels[index - 1].depth_m:
            rule = "must be deeper than the level before"
            raise broken(rule, at=("levels", index, "depth_m"), value=levels[index].depth_m, unit="m")


class LayeredCurrent(Model):
    """A current that is linear in depth between levels, and constant beyond the first and the last.

    levels: from the surface down.
    """

    kind: Literal["layers"]
    levels: Annotated[tuple[CurrentLevel, ...], Field(min_length=1, max_length=10_000)]

    @model_validator(mode="after")
    def _rises(self) -> LayeredCurrent:
        _check_depths_rise(self.levels)
        return self


class TidalCurrent(Model):
    """A current amplitude_m_s sin(2 pi t / period_s + phase_deg).

    amplitude_m_s: components along the world's axes. period_s, phase_deg: parameters of the sine; the default period is
    that of M2, the lunar tide.
    """

    kind: Literal["tidal"]
    amplitude_m_s: Velocity
    period_s: Annotated[float, InRange(60, 1e7, "s")] = 44_712.0
    phase_deg: Degrees = 0.0


class GustyCurrent(Model):
    """A mean current with Gauss-Markov gusts, drawn with the scenario's seed.

    mean_m_s: components along the world's axes. sigma_m_s: standard deviation along each world axis.
    correlation_time_s: the lag at which correlation falls to 1/e.
    """

    kind: Literal["gusts"]
    mean_m_s: Velocity = (0.0, 0.0, 0.0)
    sigma_m_s: tuple[Deviation, Deviation, Deviation]
    correlation_time_s: Annotated[float, InRange(0.1, 1e6, "s")]


class GriddedCurrent(Model):
    """A field on a grid from a file: linear along each axis inside, constant beyond its edges.

    file: a .npz with x_m (nx,), y_m (ny,), z_m (nz,) ascending and velocity_m_s (nz, ny, nx, 3), or also t_s (nt,) and
    velocity_m_s (nt, nz, ny, nx, 3); or a CSV with the columns x_m, y_m, z_m, u_m_s, v_m_s, w_m_s, in any order; or an
    ocean model's NetCDF or CSV (uwsim.scenario.read.ocean_file), whose first time is the world's beginning.
    """

    kind: Literal["grid"]
    file: AssetFile


class TideCurrent(Model):
    """The current of one constituent of the tide: an ellipse, as harmonic analyses give it.

    constituent: M2, S2, K1, O1 or another by its name in NOAA's tables. major_m_s: the largest speed. minor_m_s: the
    smallest, positive if the current turns counter-clockwise. inclination_deg: direction of the largest,
    counter-clockwise from east. phase_deg: Greenwich phase lag of the largest. begin: as of a tide.
    """

    kind: Literal["tide"]
    constituent: Constituent
    major_m_s: Deviation
    minor_m_s: MetresPerSecond = 0.0
    inclination_deg: Degrees = 0.0
    phase_deg: Degrees = 0.0
    begin: Begin = WORLD_BEGIN


CurrentSpec = Annotated[
    UniformCurrent | LayeredCurrent | TidalCurrent | GustyCurrent | GriddedCurrent | TideCurrent,
    Field(discriminator="kind"),
]


def _as_list(value: object) -> object:
    if isinstance(value, list | tuple) and value and all(isinstance(item, int | float) for item in value):
        rule = "must be a current with its kind, or a list of them; a velocity alone is current_world_m_s"
        raise broken(rule, value=list(value))
    return (value,) if isinstance(value, Mapping | Model) else value


CurrentSpecs = Annotated[
    tuple[CurrentSpec, ...],
    BeforeValidator(_as_list, json_schema_input_type=CurrentSpec | tuple[CurrentSpec, ...]),
    Field(max_length=16),
]
"""One current, or a list of currents that add up."""


class WaterLevel(Model):
    """The properties of the water at a depth.

    depth_m: depth of the level. temperature_deg_c: its temperature, at all levels or none; only a level with a speed of
    sound may be without. salinity_psu, density_kg_m3: must agree with each other. sound_speed_m_s: speed of sound, at
    all levels or none; by default derived from the other properties.
    """

    depth_m: Depth
    temperature_deg_c: Celsius | None = None
    salinity_psu: Salinity | None = None
    density_kg_m3: Density | None = None
    sound_speed_m_s: SoundSpeed | None = None

    def state(self, *, in_place: bool = False) -> WaterState:
        """Return density and salinity. in_place: whether the density was measured at the depth of this level."""
        depth_m = self.depth_m if in_place else 0.0
        warm = ASSUMED_DEG_C if self.temperature_deg_c is None else self.temperature_deg_c
        return WaterState(self.density_kg_m3, self.salinity_psu, (warm,), depth_m)

    @model_validator(mode="after")
    def _has_temperature_or_sound(self) -> WaterLevel:
        if self.temperature_deg_c is None and self.sound_speed_m_s is None:
            raise broken("must be given, or sound_speed_m_s", at=("temperature_deg_c",))
        return self


class TableProfile(Model):
    """A profile of the water that is linear between levels, which are listed here or in a file.

    levels: from the surface down. file: instead, a cast: a CSV file whose columns are the levels' keys, or a file of an
    instrument (uwsim.scenario.read.cast_file). temperature_deg_c, salinity_psu: those of the water, if the levels do
    not have them. Without any temperature, that of the water is unknown: what measures it is refused, and density,
    absorption of sound and compression are those of 10 deg C. By default, salinity is 0, or derived from density.
    """

    kind: Literal["table"]
    levels: Annotated[tuple[WaterLevel, ...], Field(min_length=1, max_length=10_000)] | None = None
    file: AssetFile | None = None
    temperature_deg_c: Celsius | None = None
    salinity_psu: Salinity | None = None

    @model_validator(mode="after")
    def _is_one_table(self) -> TableProfile:
        if (self.levels is None) == (self.file is None):
            raise broken("exactly one of levels and file must be given")
        if self.levels is not None:
            _check_depths_rise(self.levels)
            for index, level in enumerate(self.levels):
                for key in ("temperature_deg_c", "sound_speed_m_s"):
                    if (getattr(level, key) is None) != (getattr(self.levels[0], key) is None):
                        raise broken("must be given at all levels or at none", at=("levels", index, key))
            self.completed(self.levels)
        return self

    def completed(self, levels: tuple[WaterLevel, ...]) -> tuple[WaterLevel, ...]:
        """Return levels with the temperature and salinity that are given for all. Raises an error of validation."""
        given = {"temperature_deg_c": self.temperature_deg_c, "salinity_psu": self.salinity_psu}
        given = {key: value for key, value in given.items() if value is not None}
        for key in given:
            if any(getattr(level, key) is not None for level in levels):
                raise broken("must not be given: the levels have it", at=(key,), value=given[key])
        return tuple(level.model_copy(update=given) for level in levels) if given else levels


class LinearEnd(Model):
    """One end of a linear profile.

    temperature_deg_c: temperature at this end. salinity_psu, density_kg_m3: must agree with each other; density at both
    ends or none.
    """

    temperature_deg_c: Celsius
    salinity_psu: Salinity | None = None
    density_kg_m3: Density | None = None

    def state(self, depth_m: float = 0.0) -> WaterState:
        """Return density and salinity. depth_m: depth at which the density was measured; 0: at the surface."""
        return WaterState(self.density_kg_m3, self.salinity_psu, (self.temperature_deg_c,), depth_m)


class LinearProfile(Model):
    """Temperature and salinity linear from the surface down to bottom_depth_m, constant below.

    surface, bottom: the water at both ends. bottom_depth_m: depth of the bottom end, by default that of the terrain's
    deepest point. Density is also linear if both ends specify it; otherwise it follows from temperature and salinity at
    every depth (EOS-80).
    """

    kind: Literal["linear"]
    surface: LinearEnd
    bottom: LinearEnd
    bottom_depth_m: BottomDepth | None = None

    @model_validator(mode="after")
    def _gives_both_densities_or_none(self) -> LinearProfile:
        if (self.surface.density_kg_m3 is None) != (self.bottom.density_kg_m3 is None):
            raise broken("density_kg_m3 must be given at both ends or at none")
        return self


class FieldProfile(Model):
    """Temperature and salinity of an ocean model's field.

    file: NetCDF or CSV; see uwsim.scenario.read.ocean_file. Instruments measure the water at their place and time;
    density, pressure and the speed of sound are those of the column at the world's origin at its beginning.
    """

    kind: Literal["field"]
    file: AssetFile


ProfileSpec = Annotated[TableProfile | LinearProfile | FieldProfile, Field(discriminator="kind")]


ONE_WATER = ("density_kg_m3", "surface_temperature_deg_c", "bottom_temperature_deg_c", "salinity_psu")
"""Keys that a profile replaces."""


class Water(Model):
    """The water; by default still, of uniform density, and without current.

    density_kg_m3: uniform density, at atmospheric pressure; by default from the surface's temperature and the salinity
    (EOS-80). salinity_psu: uniform salinity; by default 0, or derived from a density that fresh water cannot have.
    Density and salinity must agree within 5 kg/m3. surface_temperature_deg_c, bottom_temperature_deg_c: linear between
    the surface and the terrain's deepest point. compressible: whether pressure includes the compression by the water's
    own weight (EOS-80) and gravity's growth. sound_speed_equation: automatic selects the best one that is valid
    throughout the water; an equation that is not valid there is rejected. surface: flat, or with waves.
    current_world_m_s: a uniform current. current: additional currents; all add up, to 10 m/s at most, with gusts
    counted at three sigma. profile: temperature, salinity, density and sound speed by depth, instead of the first four.
    volume_strength_db: backscatter per cubic metre, which a multibeam in physics mode receives as reverberation; by
    default none. tide: moves the surface, on which vehicles float, and with it pressure; sonars, cameras and sound see
    it at z = 0.
    """

    density_kg_m3: Density | None = None
    surface_temperature_deg_c: Celsius = 15.0
    bottom_temperature_deg_c: Celsius = 6.0
    salinity_psu: Salinity | None = None
    compressible: StrictBool = True
    sound_speed_equation: SoundSpeedEquation = "automatic"
    current_world_m_s: Velocity = (0.0, 0.0, 0.0)
    surface: SurfaceSpec = StillSurface.model_construct()
    current: CurrentSpecs = ()
    profile: ProfileSpec | None = None
    tide: Tide | None = None
    volume_strength_db: Annotated[float, InRange(-200, 0, "dB")] | None = None

    @model_validator(mode="before")
    @classmethod
    def _is_given_once(cls, data: object) -> object:
        if isinstance(data, Mapping) and data.get("profile") is not None:
            for key in ONE_WATER:
                if data.get(key) is not None:
                    raise broken("must not be given beside profile, which replaces it", at=(key,), value=data[key])
        return data

    @model_serializer(mode="wrap")
    def _without_what_the_profile_gives(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Omit the defaults that the validator would reject alongside a profile."""
        data: dict[str, Any] = plain(self)
        return data if self.profile is None else {key: item for key, item in data.items() if key not in ONE_WATER}

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> Water:
        for at, state in self._states():
            if rule := state.broken_rule:
                raise broken(rule, at=(*at, "density_kg_m3"), value=state.density_kg_m3, unit="kg/m3")
        return self

    def state(self, bottom_depth_m: float = DEEPEST_M) -> WaterState:
        """Return the density and salinity of water without a profile."""
        temperatures = self.surface_temperature_deg_c, self.bottom_temperature_deg_c
        return WaterState(self.density_kg_m3, self.salinity_psu, temperatures, self._measured_at(bottom_depth_m))

    def _measured_at(self, depth_m: float) -> float:
        return 0.0 if self.compressible else depth_m

    def _states(self) -> Iterator[tuple[tuple[str | int, ...], WaterState]]:
        """Yield each specified water state and its key path; levels in a file are read later."""
        if isinstance(self.profile, LinearProfile):
            yield ("profile", "surface"), self.profile.surface.state()
            bottom_m = self._measured_at(self.profile.bottom_depth_m or DEEPEST_M)
            yield ("profile", "bottom"), self.profile.bottom.state(bottom_m)
        elif isinstance(self.profile, FieldProfile):
            return  # the file is read later
        elif self.profile is not None:
            for index, level in enumerate(self.profile.completed(self.profile.levels or ())):
                yield ("profile", "levels", index), level.state(in_place=not self.compressible)
        else:
            yield (), self.state()
