"""Moving bodies besides vehicles' hulls, as viewers draw them: loose bodies, links of arms, fish and bubbles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.scenario.build.arm import all_shaped_links, link_mesh
from uwsim.scenario.build.cover import plume_names
from uwsim.scenario.build.loose_bodies import object_mesh
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.spec.obstacle import BUBBLES, ObstacleModel
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


MOST = 1000
"""Drawn at once, of all swarms."""
CLUSTER_M = 0.1
"""Width of a drawn cluster of bubbles: about twice the standard deviation of their places, halfway up."""


class Swarm(NamedTuple):
    """A school or a plume. drawn: how many, one in `every`. size_m: length of a fish, width of a cluster."""

    name: str
    kind: Literal["fish", "bubbles"]
    drawn: int
    every: int
    size_m: float
    colour: tuple[float, float, float]
    """Albedo: red, green and blue."""


def swarms(sim: Simulator) -> list[Swarm]:
    """Return the swarms of a simulator, in the order of its world."""
    life, plumes = sim.scenario.life or (), plume_names(sim.scenario)
    sizes = [len(sim.world.school_at(k, 0.0)[0]) for k in range(len(life) + len(plumes))]
    every = max(1, -(-sum(sizes) // MOST))
    counts = [-(-size // every) for size in sizes]
    fish = [
        Swarm(one.name, "fish", count, every, float(np.mean(one.size_m)), one.material.colour or (0.33, 0.36, 0.38))
        for one, count in zip(life, counts, strict=False)
    ]
    bubbles = [
        Swarm(name, "bubbles", count, every, CLUSTER_M, BUBBLES.colour or (0.8, 0.86, 0.88))
        for name, count in zip(plumes, counts[len(life) :], strict=True)
    ]
    return fish + bubbles


def swarm_places(sim: Simulator, found: Sequence[Swarm]) -> NDArray[np.float64]:
    """Return where those drawn of some swarms are now, (n, 6): position in the world [m] and unit vector ahead."""
    return np.vstack([np.hstack(sim.world.school_at(k, sim.time_s))[:: one.every] for k, one in enumerate(found)])
