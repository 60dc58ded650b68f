"""The files of the package uwsim_description: a scenario's vehicles as URDF, and their hulls as OBJ."""

from __future__ import annotations

import numpy as np

from uwsim.channels.families.description import Mesh, urdf
from uwsim.channels.source import Source
from uwsim.scenario import load
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.spec.vehicle import VehicleModel


def described(scenario: str, package: str) -> dict[str, str]:
    """Return the text of each file by path: urdf/NAME.urdf and meshes/NAME.obj of each vehicle. Raises ScenarioError.

    The mesh is the hull as simulated: in metres, in base_link, closed.
    """
    loaded = load(scenario)
    files = {}
    for source in Source.all_of(loaded, np.zeros(3)):
        mesh = f"meshes/{source.name}.obj"
        files[mesh] = _obj(source.entry.model)
        files[f"urdf/{source.name}.urdf"] = urdf(loaded, source, Mesh(f"package://{package}/{mesh}"))
    return files


def _obj(model: VehicleModel) -> str:
    vertices_m, triangles = vehicle_hull(model)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices_m.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    return "\n".join((f"# the hull of {model.name}, by uwsim", *lines)) + "\n"
