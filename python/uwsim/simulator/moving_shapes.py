"""Moving bodies besides vehicles' hulls, as viewers draw them: loose bodies, and the links of arms."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.build.arm import all_shaped_links, link_mesh
from uwsim.scenario.build.loose_bodies import object_mesh
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.spec.obstacle import ObstacleModel
from uwsim.scenario.spec.scenario import Scenario
from uwsim.simulator.simulator import Simulator


class MovingShape(NamedTuple):
    """A body. name: that of its label. shape: its kind and material. mesh: returns its surface in its own frame."""

    name: str
    shape: ObstacleModel
    mesh: Callable[[], tuple[Vertices, Triangles]]


def moving_shapes(scenario: Scenario) -> list[MovingShape]:
    """Return the loose bodies of a scenario, then the links that have a shape."""
    found = [
        MovingShape(body.name, body.shape, lambda body=body: object_mesh(scenario, body))  # type: ignore[misc]
        for body in scenario.objects
    ]
    return found + [
        MovingShape(f"{body} {link.shape.name}", link.shape, lambda link=link: link_mesh(link))  # type: ignore[misc]
        for body, link in all_shaped_links(scenario)
        if link.shape is not None
    ]


def shape_poses(sim: Simulator) -> Floats:
    """Return where `moving_shapes` are now, (n, 7): position [m] and quaternion x, y, z, w in the world."""
    poses = (body.pose for body in sim.objects.values())
    loose = [np.concatenate([pose.position_world_m, pose.orientation_xyzw]) for pose in poses]
    return np.vstack([np.reshape(loose, (-1, 7)), sim.link_surfaces()])
