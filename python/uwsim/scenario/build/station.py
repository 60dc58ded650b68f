"""The station in the world: its mesh, its rotation and its dock."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from uwsim.scenario.read.mesh_file import Triangles, Vertices, load_mesh
from uwsim.scenario.spec.station import Station

EXIT_M = 3.0  # ahead of the dock


def world_from_station(station: Station) -> Rotation:
    """Rotation from the station's axes to the world's."""
    return Rotation.from_euler("z", station.yaw_deg, degrees=True)


def dock_position(station: Station) -> NDArray[np.float64]:
    """(3,) the origin of a docked vehicle, world."""
    return in_world(station, station.dock_m)


def exit_position(station: Station) -> NDArray[np.float64]:
    """(3,) the origin of a vehicle that has just left the dock, world."""
    return in_world(station, np.add(station.dock_m, (EXIT_M, 0.0, 0.0)) if station.exit_m is None else station.exit_m)


def in_world(station: Station, point_m: ArrayLike) -> NDArray[np.float64]:
    """(3,) a point of the station's frame, world."""
    return np.asarray(world_from_station(station).apply(point_m) + np.asarray(station.position_m), np.float64)


def station_mesh(station: Station) -> tuple[Vertices, Triangles]:
    """The station's vertices (n, 3), world frame, and triangles (m, 3); the station must have a mesh."""
    assert station.mesh is not None
    vertices, triangles = load_mesh(station.mesh)
    return world_from_station(station).apply(vertices) + np.asarray(station.position_m), triangles
