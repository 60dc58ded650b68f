"""A profile's levels, from the scenario or a cast, and what is unknown of the water if they lack it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import get_args

from pydantic_core import PydanticCustomError

from uwsim.scenario.read.cast_file import read_cast
from uwsim.scenario.read.errors import CastWarning, ScenarioError
from uwsim.scenario.spec.water import (
    ASSUMED_DEG_C,
    Celsius,
    Density,
    Depth,
    Salinity,
    SoundSpeed,
    TableProfile,
    Water,
    WaterLevel,
)

RANGES = {
    "depth_m": Depth,
    "temperature_deg_c": Celsius,
    "salinity_psu": Salinity,
    "density_kg_m3": Density,
    "sound_speed_m_s": SoundSpeed,
}
LIMITS = {key: get_args(kind)[1] for key, kind in RANGES.items()}


def temperature_is_known(water: Water) -> bool:
    """Return whether the water's temperature is stated or measured: a profile may have the speed of sound alone."""
    if not isinstance(water.profile, TableProfile):
        return True
    return levels_of(water.profile)[0][0].temperature_deg_c is not None


def require_temperature(water: Water, what: str, at: tuple[str | int, ...] = ()) -> None:
    """Raise ScenarioError for what needs the water's temperature if it is unknown. at: its key path."""
    if not temperature_is_known(water):
        raise ScenarioError(
            f"{what}: needs the temperature of the water, which water.profile does not have: give "
            "water.profile.temperature_deg_c, or do without (in a vehicle's file, null removes a sensor)",
            at=at,
        )


def levels_of(spec: TableProfile) -> tuple[tuple[WaterLevel, ...], tuple[str, ...]]:
    """Return the levels, and the names of their places for messages. Raises ScenarioError."""
    if spec.levels is not None:
        return spec.completed(spec.levels), tuple(f"levels[{index}]" for index in range(len(spec.levels)))
    assert spec.file is not None
    levels, places, _ = _cast(spec.file, _version(spec.file))
    try:
        return spec.completed(levels), places
    except PydanticCustomError as error:
        raise ScenarioError(f"profile '{spec.file}': {error}") from None


def _version(path: Path) -> tuple[int, int]:
    try:
        state = path.stat()
    except OSError as error:
        raise ScenarioError(f"profile '{path}': {error.strerror}") from None
    return state.st_mtime_ns, state.st_size


@lru_cache(8)
def _cast(path: Path, version: tuple[int, int]) -> tuple[tuple[WaterLevel, ...], tuple[str, ...], tuple[str, ...]]:
    """version: identifies the state of the file, to keep the cache current."""
    try:
        cast = read_cast(path, f"profile '{path}'", LIMITS)
    except ValueError as error:
        raise error if isinstance(error, ScenarioError) else ScenarioError(str(error)) from None
    rows = zip(*(values.tolist() for values in cast.columns.values()), strict=True)
    levels = tuple(WaterLevel(**dict(zip(cast.columns, row, strict=True))) for row in rows)
    places = cast.lines or range(len(levels))
    return levels, tuple(f"{'line' if cast.lines else 'level'} {place}" for place in places), tuple(cast.notes)


def warn_of(spec: TableProfile, levels: Sequence[WaterLevel]) -> None:
    """Warn of what a cast's reader left out, and of what is assumed of the water."""
    notes = list(_cast(spec.file, _version(spec.file))[2]) if spec.file else []
    lacks = [key for key in ("temperature_deg_c", "salinity_psu") if getattr(levels[0], key) is None]
    if "salinity_psu" in lacks and (levels[0].density_kg_m3 is not None or not spec.file):
        lacks.remove("salinity_psu")  # derived, or 0 as everywhere by default
    assumed = {"temperature_deg_c": f"{ASSUMED_DEG_C:g} deg C", "salinity_psu": "0 psu, fresh water"}
    notes += [
        f"without {key}: density, absorption of sound and compression are those of {assumed[key]}; "
        f"water.profile.{key} states another"
        for key in lacks
    ]
    if notes:
        warnings.warn(f"profile '{spec.file or 'levels'}': {'; '.join(notes)}", CastWarning, stacklevel=2)
