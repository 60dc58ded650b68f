"""Cockpit: what a team's program sees of its vehicle, and may command, between two steps."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Mapping
from typing import Any

from uwsim.base.commands import COMMANDS, NOTE
from uwsim.base.named import did_you_mean
from uwsim.bridges.bridge import Bridge
from uwsim.channels import Channel, Table, require_live
from uwsim.channels.calls.command_services import arguments_of
from uwsim.channels.delivery.feed import Reading
from uwsim.channels.delivery.pictures import Stream
from uwsim.channels.ros.message_in import from_plain
from uwsim.channels.ros.message_out import to_plain
from uwsim.exercises import Exercise
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

MAPS = ("octomap_binary", "map_changes", "placed_ping")
"""Pings at their true places."""
CALL_S, KINDS_MAX = 5.0, 50
"""Wall time that a call may take; the number of different complaints that are kept."""


def outside_cameras(sim: Simulator) -> list[str]:
    """Return the cameras that are not on the vehicle's hull."""
    return [*sim.cameras, *(name for name, one in sim.rov.cameras.items() if one.mount.follows != "body")]


def open_channels(table: Table, live: LiveSimulator) -> list[Channel]:
    """Return what a real vehicle would have: no true pose, no map by it, and no camera that floats beside it."""
    closed = tuple(f"camera/{name}/" for name in outside_cameras(live.simulator))
    return [each for each in table.channels if not each.name.startswith(closed) and not each.name.endswith(MAPS)]


class Cockpit(Bridge):
    """The door of a team's program into a paused simulator, whose world is closed to it.

    complaints: how often each of its commands was refused, by the reason. commands, messages: how many there were, by
    topic.
    """

    peer = "the team's program"

    def __init__(self, live: LiveSimulator, exercise: Exercise, pictures_hz: float | None = None) -> None:
        """pictures_hz: the rate of the vehicle's pictures; by default each camera's own."""
        table = Table(live.simulator, truth=False, wire="standard")
        if pictures_hz is not None:
            for name in live.simulator.rov.cameras:
                table.pictures.set_stream(table.sources[0].topic(name), Stream(rate_hz=pictures_hz))
        table.rights.close_world(live)
        table.rights.allow_only([aid.kind for aid in exercise.aids])
        services = [each for each in table.services if each.permit is not None]
        super().__init__("course", live, open_channels(table, live), services)
        self.complaints, self.commands, self.messages = Counter[str](), Counter[str](), Counter[str]()
        self._arrived: list[Reading] = []
        self._answers: list[dict[str, Any]] = []

    def read_topics(self, names: list[Any]) -> None:
        """Read these topics from now on. Those that do not exist become complaints."""
        for name in names:
            if name in self.outputs:
                self.listen(name)
            else:
                self.refuse(f"topic '{name}': is none that is read{did_you_mean(str(name), self.outputs)}")

    def take(self, reading: Reading) -> None:
        """Keep a reading for the next look."""
        self._arrived.append(reading)

    def look(self) -> dict[str, Any]:
        """Return, as plain values, the messages since the last look, in order, and the answers to calls."""
        arrived, self._arrived = self._arrived, []
        answers, self._answers = self._answers, []
        self.messages.update(each.channel.name for each in arrived)
        return {"messages": [[each.channel.name, to_plain(each.message)] for each in arrived], "answers": answers}

    def obey(self, commands: Any) -> None:
        """Apply commands, pairs of a topic or service and plain values, in order.

        `note` reports what the program has found, with the arguments of the command; it goes to the referee.
        """
        for pair in commands if isinstance(commands, list) else [commands]:
            name, values = pair if isinstance(pair, list) and len(pair) == 2 else (None, None)
            try:
                if not isinstance(name, str) or not isinstance(values, Mapping):
                    raise ValueError(f"{str(pair)[:80]}: must be a list of a name and an object")
                if name in self.inputs:
                    self.apply(self.inputs[name], from_plain(self.inputs[name].type, values))
                elif name in self.services:
                    self._call(name, dict(values))
                elif name == NOTE:
                    live, arguments = require_live(self.live), arguments_of(COMMANDS[NOTE], dict(values))
                    live.command(NOTE, vehicle=live.simulator.rov.name, **arguments).result(CALL_S)
                else:
                    names = (*self.inputs, *self.services, NOTE)
                    raise ValueError(f"'{name}': is no topic or service of the vehicle{did_you_mean(name, names)}")
                self.commands[name] += 1
            except (ValueError, RuntimeError) as error:
                self.refuse(str(error))

    def _call(self, name: str, request: dict[str, Any]) -> None:
        """Call a service, and wait for its answer unless it waits for steps."""
        answered = threading.Event()

        def answer(succeeded: bool, values: Any) -> None:
            self._answers.append({"service": name, "succeeded": succeeded, "values": values})
            if not succeeded or values.get("success") is False:
                self.refuse(str(values if not succeeded else values.get("message", name)))
            answered.set()

        self.call(self.services[name], request, answer)
        answered.wait(CALL_S)

    def refuse(self, reason: str) -> None:
        """Keep why a command was rejected."""
        if reason in self.complaints or len(self.complaints) < KINDS_MAX:
            self.complaints[reason] += 1
