"""The topics and services of droppers and launchers: letting go, and how many bodies are left."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uwsim.base.commands.command import TRIGGER
from uwsim.channels.authority.steering import Steering, require_link
from uwsim.channels.channel import COMMAND, Channel, OverLink, Service
from uwsim.channels.request import Request, answered
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

COUNT = "std_msgs/msg/UInt8"
RATE_HZ = 2.0


def dropper_items(source: Source, sim: Simulator, steering: Steering) -> list[Channel | Service]:
    """Return the channels and services of a vehicle's droppers, below the name of each."""
    found: list[Channel | Service] = []
    for name in source.of(sim).droppers:
        found += [
            Channel(
                source.topic(f"{name}/drop"), "std_msgs/msg/Empty", "in", "let go of the next body",
                over_link=OverLink(COMMAND), apply=_dropped(steering, name),
            ),
            Channel(
                source.topic(f"{name}/loaded"), COUNT, "out", "how many bodies it holds", rate_hz=RATE_HZ,
                over_link=OverLink(), read=_count(source, name),
            ),
            Service(
                source.topic(f"{name}/release"), TRIGGER, answered(_called(source.name, "drop", name)),
                "let go of the next body", permit=steering.rights.require,
            ),
            Service(
                source.topic(f"{name}/reload"), TRIGGER, answered(_called(source.name, "reload", name)),
                "fill it again, as hands would", permit=steering.rights.require,
            ),
        ]  # fmt: skip
    return found


def _dropped(steering: Steering, name: str) -> Callable[[LiveSimulator, Any], object]:
    return lambda live, message: steering.ask(live, "drop", dropper=name)


def _count(source: Source, name: str) -> Callable[[Simulator], Any]:
    return lambda sim: build.message(COUNT, data=len(source.of(sim).droppers[name].loaded))


def _called(vehicle: str, command: str, name: str) -> Callable[[LiveSimulator, Request], object]:
    def call(live: LiveSimulator, request: Request) -> object:
        require_link(live, vehicle, command)
        return live.command(command, vehicle=vehicle, dropper=name).result()

    return call
