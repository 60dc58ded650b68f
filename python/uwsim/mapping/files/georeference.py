"""The location of a world on Earth: conversion between the world frame and latitude and longitude."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:  # rasterio takes half a second to import
    from rasterio.crs import CRS

WGS84 = "EPSG:4326"
SQUARED_ECCENTRICITY = 6.69437999014e-3  # of WGS 84
RADIUS_M = 6378137.0  # of WGS 84, at the equator


def metres_per_degree(latitude_deg: float) -> tuple[float, float]:
    """Return metres per degree of latitude and of longitude on WGS 84, by its radii of curvature there.

    Valid for distances of a few km. Of longitude, zero at a pole.
    """
    sine = math.sin(math.radians(latitude_deg))
    w = math.sqrt(1.0 - SQUARED_ECCENTRICITY * sine * sine)
    north = RADIUS_M * (1.0 - SQUARED_ECCENTRICITY) / w**3
    return math.radians(north), math.radians(RADIUS_M / w * math.cos(math.radians(latitude_deg)))


def metres_about(centre: tuple[float, float]) -> CRS:
    """Return a projection to metres east and north of a given longitude and latitude.

    Its scale is 1 at the centre; the scale error at 10 km is 1e-6.
    """
    from rasterio.crs import CRS

    return CRS.from_string(f"+proj=tmerc +lon_0={centre[0]!r} +lat_0={centre[1]!r} +k=1 +datum=WGS84 +units=m +no_defs")


def utm_zone(latitude_deg: float, longitude_deg: float) -> int:
    """Return the EPSG code of the UTM zone on WGS 84, without the exceptions of Norway and Svalbard."""
    zone = min(math.floor((longitude_deg + 180.0) / 6.0), 59) + 1
    return (32600 if latitude_deg >= 0.0 else 32700) + zone


@dataclass(frozen=True)
class Georeference:
    """The world's location on Earth: its origin in a coordinate system, and that system's units per simulated metre.

    crs: None for a world without a location on Earth; files then use metres east and north of the world's origin.
    """

    crs: CRS | None = None
    origin: tuple[float, float] = (0.0, 0.0)
    units_per_m: float = 1.0

    def degrees(self, position_world_m: ArrayLike) -> NDArray[np.float64]:
        """Return latitude and longitude (..., 2) [deg, WGS 84] of positions (..., 2 or 3). Needs a location on Earth.

        The conversion is PROJ's, by rasterio.
        """
        from rasterio.warp import transform

        position = np.asarray(position_world_m, np.float64)
        x, y = (self.origin[k] + self.units_per_m * position[..., k].ravel() for k in (0, 1))
        longitude, latitude = transform(self.crs, WGS84, x, y)
        return np.reshape(np.column_stack([latitude, longitude]), (*position.shape[:-1], 2))

    def world_m(self, latitude_deg: float, longitude_deg: float, altitude_m: float) -> NDArray[np.float64]:
        """Return the position (3,) of a geographic location; the water surface is at altitude 0.

        A location beyond the coordinate system's domain is infinitely far away.
        """
        from rasterio._err import CPLE_BaseError
        from rasterio.warp import transform

        x, y = [math.inf], [math.inf]
        with suppress(CPLE_BaseError):
            x, y = transform(WGS84, self.crs, [longitude_deg], [min(max(latitude_deg, -90.0), 90.0)])
        return np.array([*(np.array([x[0], y[0]]) - self.origin) / self.units_per_m, altitude_m])

    def north_rad(self, position_world_m: ArrayLike) -> float:
        """Return how far the world's y axis points to the east of true north at a position (grid convergence)."""
        position = np.asarray(position_world_m, np.float64)
        here, ahead = np.radians(self.degrees([position[:2], position[:2] + np.array([0.0, 100.0 / self.units_per_m])]))
        north, east = ahead - here
        radii = (1.0 - SQUARED_ECCENTRICITY * math.sin(here[0]) ** 2) / (1.0 - SQUARED_ECCENTRICITY)
        return math.atan2(east * math.cos(here[0]) * radii, north)


class Place(Protocol):
    """The world's location on Earth."""

    def degrees(self, position_world_m: NDArray[np.float64], /) -> Iterable[float]:
        """Return the latitude and longitude [deg] of a position (3,)."""

    def world_m(self, lat_deg: float, lon_deg: float, altitude_m: float, /) -> NDArray[np.float64]:
        """Return the position (3,) of a geographic location."""


class Home(NamedTuple):
    """A location [deg] of a point, by default the origin, of a world that has none on Earth.

    The water surface there has altitude 0.
    """

    lat_deg: float
    lon_deg: float
    x_m: float = 0.0
    y_m: float = 0.0

    def degrees(self, position_world_m: NDArray[np.float64]) -> tuple[float, float]:
        """Return the latitude and longitude [deg] of a position (3,)."""
        north, east = metres_per_degree(self.lat_deg)
        x, y = float(position_world_m[0]) - self.x_m, float(position_world_m[1]) - self.y_m
        return self.lat_deg + y / north, self.lon_deg + x / east

    def world_m(self, lat_deg: float, lon_deg: float, altitude_m: float) -> NDArray[np.float64]:
        """Return the position (3,) of a geographic location."""
        north, east = metres_per_degree(self.lat_deg)
        x, y = (lon_deg - self.lon_deg) * east, (lat_deg - self.lat_deg) * north
        return np.array([self.x_m + x, self.y_m + y, altitude_m])


HOME = Home(33.810313, -118.393867)
"""The assumed origin of the world for a scenario without a georeference: a place in the sea off California."""
