"""The station in the world frame: its mesh, orientation and dock."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.quaternions import about_z, turned
from uwsim.scenario.read.mesh_file import Triangles, Vertices, load_mesh
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.station import Station

EXIT_M = 3.0  # default distance from the dock forward to the exit


def carrier_index(scenario: Scenario) -> int | None:
    """Return the index of the vehicle that carries the station, or None."""
    carrier = scenario.station.carrier
    return None if carrier is None else [vehicle.name for vehicle in scenario.vehicles].index(carrier)


def station_at_start(scenario: Scenario) -> Station:
    """Return the station where it is at the start, in the world frame."""
    station, index = scenario.station, carrier_index(scenario)
    start = None if index is None else scenario.vehicles[index].start
    if start is None:
        return station
    x, y, z = turned(about_z(math.radians(start.yaw_deg)), station.position_m) + np.asarray(start.position_m)
    moved = {"carrier": None, "position_m": (float(x), float(y), float(z)), "yaw_deg": start.yaw_deg + station.yaw_deg}
    return station.model_copy(update=moved)


def dock_position(station: Station) -> NDArray[np.float64]:
    """Return the origin of a docked vehicle, (3,), in the world or the carrier's frame."""
    return in_world(station, station.dock_m)


def exit_position(station: Station) -> NDArray[np.float64]:
    """Return the origin of a vehicle just after undocking, (3,), in the world or the carrier's frame."""
    return in_world(station, np.add(station.dock_m, (EXIT_M, 0.0, 0.0)) if station.exit_m is None else station.exit_m)


def in_world(station: Station, point_m: ArrayLike) -> NDArray[np.float64]:
    """Convert points (3,) or (n, 3) from the station's frame to the world's, or to its carrier's if it has one."""
    return turned(about_z(math.radians(station.yaw_deg)), point_m) + np.asarray(station.position_m, np.float64)


def station_mesh(station: Station) -> tuple[Vertices, Triangles]:
    """Return the station's vertices (n, 3), world frame, and triangles (m, 3). The station must have a mesh."""
    assert station.mesh is not None
    vertices, triangles = load_mesh(station.mesh)
    return in_world(station, vertices), triangles
