"""The simulated vehicle behind a MAVLink system, as shared by the parts of the bridge."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from uwsim.bridges.actions import Action
from uwsim.bridges.mavlink.component import Say
from uwsim.bridges.mavlink.earth import Home
from uwsim.bridges.mavlink.telemetry import State
from uwsim.channels.steering import log_error
from uwsim.live import LiveSimulator

COMMAND_S = 5.0


@dataclass
class Craft:
    """A vehicle of a live simulator.

    name: the vehicle's name. action: its action `fly_path`, or None if it has none. home: the location of the world's
    origin. say: sends a text to the ground stations. output: the autopilot's messages to all stations, queued by any
    thread. state: the latest reading.
    """

    live: LiveSimulator
    name: str
    action: Action | None
    home: Home
    say: Say
    output: deque[Any] = field(default_factory=lambda: deque(maxlen=1000))
    state: State | None = None

    @property
    def vehicle(self) -> Any:
        """The simulated vehicle."""
        return self.live.simulator.vehicles[self.name]

    def begin(self, command: str, **arguments: Any) -> Future[Any]:
        """Issue a command if the station's pilot permits it. Raises ValueError."""
        if self.action is not None:
            self.action.steering.rights.require(command, {"data": arguments.get("on", True)})
        return self.live.command(command, vehicle=self.name, **arguments)

    def command(self, command: str, **arguments: Any) -> None:
        """Issue a command, and wait until it has taken effect. Raises ValueError or RuntimeError."""
        try:
            self.begin(command, **arguments).result(timeout=COMMAND_S)
        except TimeoutError:
            raise RuntimeError(f"{command}: had no effect within {COMMAND_S:g} s") from None

    def send(self, command: str, **arguments: Any) -> None:
        """Issue a command without waiting. A failure is logged. Raises ValueError."""
        self.begin(command, **arguments).add_done_callback(log_error)
