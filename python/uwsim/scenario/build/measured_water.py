"""The sources of a scenario's profiles and currents: casts, fields of an ocean model, and the harmonics of tides.

Arguments: mean longitudes of Moon and Sun after the Explanatory Supplement to the Astronomical Ephemeris (1961), and
the Doodson numbers of Foreman 1977, "Manual for tidal heights analysis and prediction", Pacific Marine Science Report
77-10. Nodal corrections: Pugh 1987, "Tides, surges and mean sea-level", table 4.3, and for J1 and OO1 Schureman 1958,
"Manual of harmonic analysis and prediction of tides", to first order. They change over 18.6 years, and are taken for
constant in a run.
"""

from __future__ import annotations

import cmath
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.mapping.files.georeference import Georeference, metres_per_degree
from uwsim.scenario.read.cast_file import read_cast
from uwsim.scenario.read.errors import CastWarning, ScenarioError
from uwsim.scenario.read.ocean_file import OceanField, read_ocean
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


FARTHEST_DEG = 2.0
Place = Callable[[], Georeference]


@lru_cache(4)
def _read(path: Path, version: tuple[int, int]) -> OceanField:
    """version: identifies the state of the file, to keep the cache current."""
    return read_ocean(path)


def _field(path: Path) -> OceanField:
    try:
        state = path.stat()
    except OSError as error:
        raise ScenarioError(f"ocean '{path}': {error.strerror}") from None
    return _read(path, (state.st_mtime_ns, state.st_size))


def surface_mean(path: Path) -> tuple[float, float]:
    """Return a field's mean temperature [deg C] and salinity [psu] at the surface at time 0. Raises ScenarioError."""
    temperature, salinity = _field(path).need(path, "temperature", "salinity")
    return float(temperature[0, -1].mean()), float(salinity[0, -1].mean())


class Axes(NamedTuple):
    """Axes of a grid in the world, rising.

    order: the columns of the field that the values of x_m are. turn_rad: how far the world's y axis points to the east
    of true north.
    """

    x_m: Floats
    y_m: Floats
    z_m: Floats
    t_s: Floats
    order: NDArray[np.intp]
    turn_rad: float


def axes_of(field: OceanField, path: Path, place: Place | None) -> Axes:
    """Return the axes of a field in metres east and north of the world's origin. Raises ScenarioError.

    Longitudes may count from 0 to 360 deg, and a field may cross the date line. Meridians are taken for parallel: at 10
    km from the origin in latitude 45, that is off by 12 m. They are taken to be parallel to the world's y axis, too:
    where a projection turns it by 2 deg, a place 1 km away is off by 35 m.
    """
    world = None if place is None else place()
    if world is None or world.crs is None:
        raise ScenarioError(f"ocean '{path}': the scenario must have a place on Earth: give it the key earth")
    latitude_deg, longitude_deg = world.degrees(np.zeros(2)).tolist()
    east_deg, order = np.unique((field.longitude_deg - longitude_deg + 180.0) % 360.0 - 180.0, return_index=True)
    north_deg = field.latitude_deg - latitude_deg
    if max(max(float(axis[0]), -float(axis[-1])) for axis in (east_deg, north_deg)) > FARTHEST_DEG:
        raise ScenarioError(
            f"ocean '{path}': covers {field.latitude_deg[0]:.2f} to {field.latitude_deg[-1]:.2f} N, "
            f"{field.longitude_deg[0]:.2f} to {field.longitude_deg[-1]:.2f} E: the world's origin, "
            f"{latitude_deg:.2f} N {longitude_deg:.2f} E, must be within {FARTHEST_DEG:g} deg of it"
        )
    north, east = metres_per_degree(latitude_deg)
    return Axes(east * east_deg, north * north_deg, field.z_m, field.t_s, order, world.north_rad(np.zeros(2)))


def ocean_current(path: Path, place: Place | None) -> _core.Current:
    """Return the current of a field; without a vertical velocity, there is none. Raises ScenarioError."""
    field = _field(path)
    u, v = field.need(path, "u", "v")
    axes = axes_of(field, path, place)
    cosine, sine = np.cos(axes.turn_rad), np.sin(axes.turn_rad)
    up = field.values.get("w", np.zeros_like(u))
    velocity = np.stack([cosine * u - sine * v, sine * u + cosine * v, up], axis=-1)[..., axes.order, :]
    return _core.Current.gridded(axes.x_m, axes.y_m, axes.z_m, velocity, axes.t_s)


def put_masses(water: _core.Water, path: Path, place: Place | None) -> None:
    """Give the water a field's temperature and salinity, and as its profile their column at the origin at time 0.

    Raises ScenarioError or ValueError.
    """
    field = _field(path)
    temperature, salinity = field.need(path, "temperature", "salinity")
    axes = axes_of(field, path, place)
    columns = (temperature[..., axes.order], salinity[..., axes.order])
    water.set_masses(axes.x_m, axes.y_m, axes.z_m, axes.t_s, *columns)
    at = np.column_stack([np.zeros((len(axes.z_m), 2)), axes.z_m])[::-1]
    warm, salt = water.temperature_at_deg_c(at), water.salinity_at_points_psu(at)
    density = [_core.sea_water_density_kg_m3(t, s) for t, s in zip(warm, salt, strict=True)]
    water.profile = _core.WaterProfile(-at[:, 2], warm, salt, density)


EPOCH = datetime(1899, 12, 31, 12, tzinfo=UTC)
LONGITUDES_DEG = np.array([  # constant, per day, per (10000 days)^2 and ^3: s, h, p, N' = -N, p1
    [270.434164, 13.1763965268, -0.0000850, 0.000000039],
    [279.696678, 0.9856473354, 0.00002267, 0.0],
    [334.329556, 0.1114040803, -0.0007739, -0.00000026],
    [-259.183275, 0.0529539222, -0.0001557, -0.000000050],
    [281.220844, 0.0000470684, 0.0000339, 0.000000070],
])  # fmt: skip
DOODSON = {  # multiples of tau (the mean lunar time), s, h, p and p1, and a constant [cycles]
    "SSA": (0, 0, 2, 0, 0, 0.0), "MM": (0, 1, 0, -1, 0, 0.0), "MF": (0, 2, 0, 0, 0, 0.0),
    "2Q1": (1, -3, 0, 2, 0, -0.25), "Q1": (1, -2, 0, 1, 0, -0.25), "RHO": (1, -2, 2, -1, 0, -0.25),
    "O1": (1, -1, 0, 0, 0, -0.25), "P1": (1, 1, -2, 0, 0, -0.25), "K1": (1, 1, 0, 0, 0, -0.75),
    "J1": (1, 2, 0, -1, 0, -0.75), "OO1": (1, 3, 0, 0, 0, -0.75),
    "2N2": (2, -2, 0, 2, 0, 0.0), "MU2": (2, -2, 2, 0, 0, 0.0), "N2": (2, -1, 0, 1, 0, 0.0),
    "NU2": (2, -1, 2, -1, 0, 0.0), "M2": (2, 0, 0, 0, 0, 0.0), "LAM2": (2, 1, -2, 1, 0, -0.5),
    "L2": (2, 1, 0, -1, 0, -0.5), "T2": (2, 2, -3, 0, 1, 0.0), "S2": (2, 2, -2, 0, 0, 0.0),
    "R2": (2, 2, -1, 0, -1, -0.5), "K2": (2, 2, 0, 0, 0, 0.0), "M3": (3, 0, 0, 0, 0, -0.5),
}  # fmt: skip
LUNAR = (1.0, -0.037, -2.1)
NODAL = {  # factor's constant and cos N, phase's sin N [deg]
    "MM": (1.0, -0.130, 0.0), "MF": (1.043, 0.414, -23.7),
    **dict.fromkeys(("2Q1", "Q1", "RHO", "O1"), (1.009, 0.187, 10.8)),
    "K1": (1.006, 0.115, -8.9), "J1": (1.013, 0.168, -12.9), "OO1": (1.103, 0.650, -36.7),
    **dict.fromkeys(("2N2", "MU2", "N2", "NU2", "M2", "LAM2"), LUNAR), "K2": (1.024, 0.286, -17.7),
    "M3": (1.0, -0.056, -3.2),
}  # fmt: skip
NODAL_L2 = (  # of the sum 1 + amplitude exp(i angle): amplitude, and multiples of 2 p and N in the angle
    (-0.2505, 1, 0), (-0.1102, 1, -1), (-0.0156, 1, -2), (-0.0370, 0, 1),
)  # fmt: skip
SHALLOW: Mapping[str, Mapping[str, int]] = {  # multiples of others
    "MSF": {"S2": 1, "M2": -1}, "2SM2": {"S2": 2, "M2": -1}, "MK3": {"M2": 1, "K1": 1}, "2MK3": {"M2": 2, "K1": -1},
    "MN4": {"M2": 1, "N2": 1}, "M4": {"M2": 2}, "MS4": {"M2": 1, "S2": 1}, "S4": {"S2": 2}, "M6": {"M2": 3},
    "S6": {"S2": 3}, "M8": {"M2": 4},
}  # fmt: skip
CONSTITUENTS = (*DOODSON, *SHALLOW)
"""Those of NOAA's tables by their names there, without SA, S1 and M1, whose arguments differ between agencies."""
DAY_S = 86400.0


class Harmonic(NamedTuple):
    """A constituent: amplitude times factor, and cos(speed_rad_s t + argument_rad - its Greenwich phase lag)."""

    factor: float
    speed_rad_s: float
    argument_rad: float


def harmonic(constituent: str, begin: str) -> Harmonic:
    """Return a constituent of CONSTITUENTS, t being the time since `begin` (ISO 8601, UTC by default)."""
    time = datetime.fromisoformat(begin)
    time = time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
    days = (time - EPOCH).total_seconds() / DAY_S
    tens = days / 1e4
    s, h, p, minus_node, p1 = LONGITUDES_DEG @ [1.0, days, tens**2, tens**3] / 360.0
    day = (time.hour + (time.minute + (time.second + 1e-6 * time.microsecond) / 60.0) / 60.0) / 24.0
    slopes = LONGITUDES_DEG @ [0.0, 1.0, 2e-4 * tens, 3e-4 * tens**2] / 360.0
    node_rad = -math.tau * minus_node
    factor, speed, turn_rad = 1.0, 0.0, 0.0
    for part, count in SHALLOW.get(constituent, {constituent: 1}).items():
        *numbers, constant = DOODSON[part]
        argument = np.dot(numbers, (day + h - s, s, h, p, p1)) + constant
        size, ahead_rad = _nodal(part, node_rad, math.tau * p)
        factor *= size ** abs(count)
        turn_rad += count * (math.tau * (argument % 1.0) + ahead_rad)
        speed += count * np.dot(numbers, (1.0 + slopes[1] - slopes[0], *slopes[:3], slopes[4]))  # cycles per day
    return Harmonic(factor, math.tau * float(speed) / DAY_S, float(turn_rad))


def _nodal(part: str, node_rad: float, perigee_rad: float) -> tuple[float, float]:
    """Return factor and phase [rad] of the nodes, for L2 also of the Moon's perigee."""
    if part == "L2":
        turns = ((size, 2.0 * twice * perigee_rad + nodes * node_rad) for size, twice, nodes in NODAL_L2)
        found = 1.0 + sum(cmath.rect(size, angle) for size, angle in turns)
        return abs(found), cmath.phase(found)
    mean, cosine, sine_deg = NODAL.get(part, (1.0, 0.0, 0.0))
    return mean + cosine * math.cos(node_rad), math.radians(sine_deg) * math.sin(node_rad)
