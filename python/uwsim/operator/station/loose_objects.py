"""The loose bodies of a simulator as the page shows them: their surfaces, and a topic with their true poses."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.operator.station.scene import glb
from uwsim.scenario.build.loose_bodies import object_mesh
from uwsim.simulator.simulator import Simulator

TOPIC = "station/objects"
TYPE = "tf2_msgs/msg/TFMessage"
PERIOD_S = 0.1
WAYS = 200  # directions in which a body's outermost corners are found


class LooseObjects:
    """Publishes the true poses of a simulator's loose bodies, in odom, while a page asks for them.

    origin_m: the world's origin in odom. Without loose bodies, nothing is offered.
    """

    def __init__(self, live: LiveSimulator, node: Node, origin_m: NDArray[np.float64]) -> None:
        self._live, self._node, self._origin_m = live, node, origin_m
        self._bodies = live.simulator.scenario.objects

    def topics(self) -> list[GuestTopic]:
        """Return the topic, if there are loose bodies."""
        return [GuestTopic(TOPIC, TYPE, "where loose bodies are", latched=True)] if self._bodies else []

    def start(self) -> None:
        """Start to publish. The simulator must be stepping."""
        if self._bodies:
            self._live.every(PERIOD_S, self._read, self._publish)

    def described(self) -> list[Values]:
        """Return the entry `objects` of `scene.json`."""
        scenario = self._live.simulator.scenario
        return [
            {
                "name": body.name, "label": body.shape.kind, "url": f"/scene/object/{k}.glb",
                "colour": None if (colour := body.shape.material.colour) is None else list(colour),
                "corners_m": np.round(outermost(object_mesh(scenario, body)[0]), 3).tolist(),
            }
            for k, body in enumerate(self._bodies)
        ]  # fmt: skip

    def surface(self, number: int) -> bytes:
        """Return a body as binary glTF, in its axes. Raises ValueError if there is none with this number."""
        if not 0 <= number < len(self._bodies):
            raise ValueError(f"object {number}: there are {len(self._bodies)}")
        return glb(object_mesh(self._live.simulator.scenario, self._bodies[number]), np.zeros(3))

    def _read(self, sim: Simulator) -> tuple[int, Any]:
        transforms = [
            build.transform(
                sim.time_ns, "odom", body.name, body.pose.position_world_m + self._origin_m, body.pose.orientation_xyzw
            )
            for body in sim.objects.values()
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
