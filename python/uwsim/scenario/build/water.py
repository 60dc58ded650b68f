"""A scenario's water as core objects: waves, currents and profiles, including those read from files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.scenario.build.earth import STANDARD_M_S2
from uwsim.scenario.build.measured_water import (
    Place,
    harmonic,
    levels_of,
    ocean_current,
    put_masses,
    surface_mean,
    warn_of,
)
from uwsim.scenario.read.current_grid import is_ocean, read_current_grid
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.water import (
    AirySurface,
    CurrentSpec,
    FieldProfile,
    GustyCurrent,
    JonswapSurface,
    LayeredCurrent,
    LinearProfile,
    StillSurface,
    TableProfile,
    TidalCurrent,
    TideCurrent,
    UniformCurrent,
    Water,
)
from uwsim.scenario.spec.water_parts import Tide, WaterState

LINEAR_LEVELS = 17  # enough for linear pieces to match EOS-80 within 0.02 kg/m3 from -2 to 40 deg C


def build_water(
    water: Water, *, bottom_depth_m: float, seed: int, gravity_m_s2: float = STANDARD_M_S2, place: Place | None = None
) -> _core.Water:
    """Return the water. Raises ScenarioError.

    bottom_depth_m: greatest depth of the terrain, used as a default. place: returns the world's place on Earth, which
    an ocean model's field needs.
    """
    native = _core.Water()
    native.gravity_m_s2 = gravity_m_s2
    state = water.state(bottom_depth_m)
    native.density_kg_m3 = state.density
    native.surface_temperature_deg_c = water.surface_temperature_deg_c
    native.bottom_temperature_deg_c = water.bottom_temperature_deg_c
    native.bottom_depth_m = bottom_depth_m
    native.salinity_psu = state.salinity
    native.compressible = water.compressible
    native.current_world_m_s = steady_current_m_s(water)
    try:
        _require_agreement(state, "water.", at=("density_kg_m3",))
        native.waves = _waves(water, bottom_depth_m, seed, gravity_m_s2)
        for index, spec in enumerate(water.current):
            for current in _currents(spec, seed + index, place):
                native.add_current(current)
        if tidal := [spec for spec in water.current if isinstance(spec, TideCurrent)]:
            native.add_current(_ellipses(tidal))
        if water.tide is not None:
            native.set_tide(_tide(water.tide))
        if isinstance(water.profile, FieldProfile):
            put_masses(native, water.profile.file, place)
        elif water.profile is not None:
            native.profile = _profile(water, water.profile, bottom_depth_m)
        if water.profile is not None:
            native.density_kg_m3 = native.density_at_kg_m3(0.0)
            native.salinity_psu = native.salinity_at_psu(0.0)
        native.check()
        native.sound_speed_equation = water.sound_speed_equation
    except ScenarioError:
        raise
    except ValueError as error:
        raise ScenarioError(str(error)) from None
    return native


def _waves(water: Water, bottom_depth_m: float, seed: int, gravity_m_s2: float) -> _core.Waves | None:
    surface = water.surface
    if not isinstance(surface, StillSurface):
        _require_water_as_deep(surface.depth_m, bottom_depth_m)
    if isinstance(surface, AirySurface):
        return _core.Waves.airy(
            surface.amplitude_m,
            surface.period_s,
            float(np.radians(surface.heading_deg)),
            float(np.radians(surface.phase_deg)),
            surface.depth_m or bottom_depth_m,
            gravity_m_s2,
        )
    if isinstance(surface, JonswapSurface):
        return _core.Waves.jonswap(
            surface.significant_height_m,
            surface.peak_period_s,
            surface.peak_enhancement,
            float(np.radians(surface.heading_deg)),
            surface.spreading_exponent,
            surface.component_count,
            seed,
            surface.depth_m or bottom_depth_m,
            gravity_m_s2,
        )
    return None


def _require_water_as_deep(depth_m: float | None, bottom_depth_m: float) -> None:
    if depth_m is not None and depth_m > bottom_depth_m + 1e-3:  # terrain heights are float32
        raise ScenarioError(
            f"water.surface.depth_m = {depth_m:g} m: must be at most {bottom_depth_m:g} m, as deep as the terrain is",
            at=("surface", "depth_m"),
        )


def steady_current_m_s(water: Water) -> Floats:
    """Return the part of the current that is constant in space and time: (3,), world frame."""
    parts = [np.asarray(water.current_world_m_s)]
    for current in water.current:
        if isinstance(current, UniformCurrent):
            parts.append(np.asarray(current.velocity_m_s))
        elif isinstance(current, GustyCurrent):
            parts.append(np.asarray(current.mean_m_s))
    return np.asarray(np.sum(parts, axis=0), np.float64)


def surface_density_kg_m3(water: Water) -> float:
    """Return the density at the surface, for which neutral vehicles are trimmed. Raises ScenarioError."""
    if water.profile is None:
        return water.state().density
    if isinstance(water.profile, FieldProfile):
        return _core.sea_water_density_kg_m3(*surface_mean(water.profile.file))
    top = water.profile.surface if isinstance(water.profile, LinearProfile) else levels_of(water.profile)[0][0]
    return top.state().density


def _require_agreement(state: WaterState, where: str, at: tuple[str | int, ...] = ()) -> None:
    if rule := state.broken_rule:
        raise ScenarioError(f"{where}density_kg_m3 = {state.density_kg_m3:g} kg/m3: {rule}", at=at)


def _currents(current: CurrentSpec, seed: int, place: Place | None) -> list[_core.Current]:
    """Return the parts of a current that vary in space or time, without those of tides."""
    if isinstance(current, UniformCurrent | TideCurrent):
        return []
    if isinstance(current, LayeredCurrent):
        levels = current.levels
        return [_core.Current.layered([level.depth_m for level in levels], [level.velocity_m_s for level in levels])]
    if isinstance(current, TidalCurrent):
        return [_core.Current.tidal(current.amplitude_m_s, current.period_s, float(np.radians(current.phase_deg)))]
    if isinstance(current, GustyCurrent):
        return [_core.Current.gusty(current.sigma_m_s, current.correlation_time_s, seed)]
    try:
        if is_ocean(current.file):
            return [ocean_current(current.file, place)]
        return [_core.Current.gridded(*read_current_grid(current.file))]
    except ScenarioError:
        raise
    except ValueError as error:
        raise ScenarioError(f"current '{current.file}': {error}") from None


def _ellipses(currents: Sequence[TideCurrent]) -> _core.Current:
    """Return the sum of constituents' ellipses."""
    speeds_rad_s, cosines_m_s, sines_m_s = [], [], []
    for each in currents:
        factor, speed_rad_s, argument_rad = harmonic(each.constituent, each.begin)
        lag_rad, turn_rad = np.radians(each.phase_deg) - argument_rad, np.radians(each.inclination_deg)
        ahead = factor * np.array([np.cos(turn_rad), np.sin(turn_rad)])
        major, minor = each.major_m_s * ahead, each.minor_m_s * np.array([-ahead[1], ahead[0]])
        speeds_rad_s.append(speed_rad_s)
        cosines_m_s.append(np.cos(lag_rad) * major - np.sin(lag_rad) * minor)
        sines_m_s.append(np.sin(lag_rad) * major + np.cos(lag_rad) * minor)
    return _core.Current.harmonic(speeds_rad_s, cosines_m_s, sines_m_s)


def _tide(tide: Tide) -> Floats:
    """Return rows of amplitude [m], speed [rad/s] and phase [rad]."""
    rows = []
    for each in tide.constituents:
        factor, speed_rad_s, argument_rad = harmonic(each.constituent, tide.begin)
        rows.append((factor * each.amplitude_m, speed_rad_s, np.radians(each.phase_deg) - argument_rad))
    return np.array(rows, np.float64)


def _profile(water: Water, spec: TableProfile | LinearProfile, bottom_depth_m: float) -> _core.WaterProfile:
    if isinstance(spec, LinearProfile):
        return _linear(spec, spec.bottom_depth_m or bottom_depth_m)
    levels, places = levels_of(spec)
    warn_of(spec, levels)
    states = [level.state(in_place=not water.compressible) for level in levels]
    for state, place in zip(states, places, strict=True):
        _require_agreement(state, f"profile '{spec.file}': {place}: " if spec.file else f"profile.{place}.")
    speeds = [level.sound_speed_m_s for level in levels]
    return _core.WaterProfile(
        [level.depth_m for level in levels],
        [state.temperatures_deg_c[0] for state in states],
        [state.salinity for state in states],
        [state.density for state in states],
        speeds if speeds[0] is not None else None,
    )


def _linear(spec: LinearProfile, bottom_depth_m: float) -> _core.WaterProfile:
    down = np.linspace(0.0, 1.0, LINEAR_LEVELS)
    temperature = np.interp(down, (0, 1), (spec.surface.temperature_deg_c, spec.bottom.temperature_deg_c))
    salinity = np.interp(down, (0, 1), (spec.surface.state().salinity, spec.bottom.state().salinity))
    if spec.surface.density_kg_m3 is not None and spec.bottom.density_kg_m3 is not None:
        ends = [0, -1]
        density = [spec.surface.density_kg_m3, spec.bottom.density_kg_m3]
        return _core.WaterProfile(down[ends] * bottom_depth_m, temperature[ends], salinity[ends], density)
    density = [_core.sea_water_density_kg_m3(t, s) for t, s in zip(temperature, salinity, strict=True)]
    return _core.WaterProfile(down * bottom_depth_m, temperature, salinity, density)
