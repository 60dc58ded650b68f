"""Fish and bubbles as the page shows them: a topic with their true places."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.simulator.moving_shapes import swarm_places, swarms
from uwsim.simulator.simulator import Simulator

TOPIC = "station/life"
TYPE = "std_msgs/msg/Float32MultiArray"
PERIOD_S = 0.2


class Life:
    """Publishes the true places of fish and bubbles, in odom.

    origin_m: the world's origin in odom. Without either, nothing is offered.
    """

    def __init__(self, live: LiveSimulator, node: Node, origin_m: NDArray[np.float64]) -> None:
        self._live, self._node = live, node
        self._shift_m = np.concatenate([origin_m, np.zeros(3)])
        self._swarms = swarms(live.simulator)

    def topics(self) -> list[GuestTopic]:
        """Return the topic, if there is any life."""
        description = "where fish and bubbles are: x, y, z [m] and a unit vector ahead of each"
        return [GuestTopic(TOPIC, TYPE, description, latched=True)] if self._swarms else []

    def start(self) -> None:
        """Start to publish. The simulator must be stepping."""
        if self._swarms:
            self._live.every(PERIOD_S, self._read, self._publish)

    def described(self) -> Values | None:
        """Return the entry `life` of the description."""
        if not self._swarms:
            return None
        shown = ("name", "kind", "drawn", "size_m")
        found = [{key: getattr(one, key) for key in shown} | {"colour": list(one.colour)} for one in self._swarms]
        return {"topic": f"/{TOPIC}", "swarms": found}

    def _read(self, sim: Simulator) -> tuple[int, Any]:
        places = (swarm_places(sim, self._swarms) + self._shift_m).astype(np.float32)
        return sim.time_ns, build.message(TYPE, data=places.ravel())

    def _publish(self, found: tuple[int, Any]) -> None:
        time_ns, message = found
        self._node.publish(TOPIC, message, time_ns)
