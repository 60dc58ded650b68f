"""Topics of a user's own, one for each value of Simulator.log."""

from collections.abc import Set
from typing import Any

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.simulator.simulator import Simulator

TYPES = {float: "std_msgs/msg/Float64", bool: "std_msgs/msg/Bool", str: "std_msgs/msg/String"}


def logged_channels(sim: Simulator, taken: Set[str]) -> list[Channel]:
    """Return the topics of what has been logged so far. Raises ValueError for a name of another topic."""
    if both := sim.logged.values.keys() & taken:
        raise ValueError(f"log '/{min(both)}': the name is taken by a topic of the scenario")
    return [_channel(name, TYPES[type(value)]) for name, value in sim.logged.values.items()]


def _channel(name: str, kind: str) -> Channel:
    def follow(sim: Simulator, take: Any) -> Any:
        return sim.logged.listen(name, lambda value: take(build.message(kind, data=value)))

    read = lambda sim: build.message(kind, data=sim.logged.values[name])  # noqa: E731
    return Channel(name, kind, "out", "a value of the user's own", read=read, delivery=Delivery(True, follow=follow))
