"""The station in the world: its mesh and its rotation."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.scenario.read.mesh_file import Triangles, Vertices, load_mesh
from uwsim.scenario.spec.station import Station


def world_from_station(station: Station) -> Rotation:
    """Rotation from the station's axes to the world's."""
    return Rotation.from_euler("z", station.yaw_deg, degrees=True)


def station_mesh(station: Station) -> tuple[Vertices, Triangles]:
    """The station's vertices (n, 3), world frame, and triangles (m, 3); the station must have a mesh."""
    assert station.mesh is not None
    vertices, triangles = load_mesh(station.mesh)
    return world_from_station(station).apply(vertices) + np.asarray(station.position_m), triangles
