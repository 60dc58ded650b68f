"""Fields of an ocean model in a scenario's world: currents and water masses on a grid of positions and times."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.files.georeference import Georeference, metres_per_degree
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.ocean_file import OceanField, read_ocean

Floats = NDArray[np.float64]
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
