"""Loose bodies and links of arms as the page shows them: their surfaces, and a topic with their true poses."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.operator.station.scene.scene import glb, own_colours
from uwsim.simulator.moving_shapes import moving_shapes, shape_poses
from uwsim.simulator.simulator import Simulator

TOPIC = "station/objects"
TYPE = "tf2_msgs/msg/TFMessage"
PERIOD_S = 0.1
WAYS = 200  # directions in which a body's outermost corners are found


class LooseObjects:
    """Publishes the true poses of loose bodies and links, in odom, while a page asks for them.

    origin_m: the world's origin in odom. Without either, nothing is offered.
    """

    def __init__(self, live: LiveSimulator, node: Node, origin_m: NDArray[np.float64]) -> None:
        self._live, self._node, self._origin_m = live, node, origin_m
        self._bodies = moving_shapes(live.simulator.scenario)

    def topics(self) -> list[GuestTopic]:
        """Return the topic, if there are any bodies."""
        description = "where loose bodies and links of arms are"
        return [GuestTopic(TOPIC, TYPE, description, latched=True)] if self._bodies else []

    def start(self) -> None:
        """Start to publish. The simulator must be stepping."""
        if self._bodies:
            self._live.every(PERIOD_S, self._read, self._publish)

    def described(self) -> list[Values]:
        """Return the entry `objects` of `scene.json`."""
        return [
            {
                "name": body.name, "label": body.shape.kind, "url": f"/scene/object/{k}.glb",
                "colour": None if (colour := body.shape.material.colour) is None else list(colour),
                "corners_m": np.round(outermost(body.mesh()[0]), 3).tolist(),
            }
            for k, body in enumerate(self._bodies)
        ]  # fmt: skip

    def surface(self, number: int) -> bytes:
        """Return a body as binary glTF, in its axes. Raises ValueError if there is none with this number."""
        if not 0 <= number < len(self._bodies):
            raise ValueError(f"object {number}: there are {len(self._bodies)}")
        body, mesh = self._bodies[number], self._bodies[number].mesh()
        return glb(mesh, np.zeros(3), own_colours(body.shape.texture(), len(mesh[1])))

    def _read(self, sim: Simulator) -> tuple[int, Any]:
        transforms = [
            build.transform(sim.time_ns, "odom", body.name, pose[:3] + self._origin_m, pose[3:])
            for body, pose in zip(self._bodies, shape_poses(sim), strict=True)
        ]
        return sim.time_ns, build.message(TYPE, transforms=transforms)

    def _publish(self, found: tuple[int, Any]) -> None:
        time_ns, message = found
        self._node.publish(TOPIC, message, time_ns)


def outermost(vertices_m: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the vertices (n, 3) of a solid that are outermost in WAYS directions, spread by the golden angle."""
    k = np.arange(WAYS) + 0.5
    turn, up = np.pi * (1.0 + 5.0**0.5) * k, 1.0 - 2.0 * k / WAYS
    flat = np.sqrt(1.0 - up**2)
    ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), up])
    vertices = np.asarray(vertices_m, np.float64)
    found: NDArray[np.float64] = vertices[np.unique(np.argmax(vertices @ ways, axis=0))]
    return found
