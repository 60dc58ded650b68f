"""The simulated vehicle behind a MAVLink system, as shared by the parts of the bridge."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future, wait
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uwsim.base.commands import command_named
from uwsim.bridges.actions import Action
from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.mavlink.component import SendText
from uwsim.bridges.mavlink.earth import Vector
from uwsim.bridges.mavlink.state import State
from uwsim.channels.authority.steering import log_error
from uwsim.live import LiveSimulator
from uwsim.mapping.files.georeference import Place
from uwsim.missions import OwnVehicle

COMMAND_S = 5.0
LOOK_S = 0.005  # time between looks at the network while a command takes effect


@dataclass
class Craft:
    """A vehicle of a live simulator.

    name: the vehicle's name. action: its action `fly_path`, or None if it has none. home: the location of the world's
    origin. send_text: sends a text to the ground stations. output: the autopilot's messages to all stations, or
    functions that return them when they are sent, queued by any thread. state: the latest reading. meanwhile: called
    while a command takes effect, to handle what is more urgent. interruptions: how many stops and disarms there were;
    each ends the command that waits. launch_world_m: the home position, at the surface. is_flying: whether it flies by
    itself. gain: of the sticks. channels_us: the pulses of the RC channels, by number. pictures: takes a
    picture for an item of a mission, if there is a folder for them. fence: whether there is one, whether it acts, and
    whether it is kept, as it is if there is none.
    """

    live: LiveSimulator
    name: str
    action: Action | None
    home: Place
    send_text: SendText
    output: Waiting[Any] = field(default_factory=lambda: Waiting(1000))
    state: State | None = None
    meanwhile: Callable[[], object] = lambda: None
    interruptions: int = 0
    launch_world_m: Vector = field(default_factory=lambda: np.zeros(3))
    is_flying: bool = False
    gain: float = 0.5
    pictures: Callable[[OwnVehicle, int], object] | None = None
    channels_us: dict[int, int] = field(default_factory=dict)
    fence: tuple[bool, bool, bool] = (False, False, True)

    @property
    def vehicle(self) -> Any:
        """The simulated vehicle."""
        return self.live.simulator.vehicles[self.name]

    def require(self, command: str, **arguments: Any) -> None:
        """Raise ValueError unless a client may issue a command now."""
        if self.action is not None:
            self.action.steering.rights.require(command, {"data": arguments.get("on", True)})

    def begin(self, command: str, **arguments: Any) -> Future[Any]:
        """Issue a command if the station's pilot permits it. Raises ValueError."""
        self.require(command, **arguments)
        if self.action is not None and command_named(command).steers:  # which replaces what steers now
            return self.action.steering.give(self.live, command, **arguments)
        return self.live.command(command, vehicle=self.name, **arguments)

    def command(self, command: str, **arguments: Any) -> None:
        """Issue a command, and wait until it has taken effect. Raises ValueError or RuntimeError."""
        self.wait(self.begin(command, **arguments), command)

    def wait(self, order: Future[Any], what: str, *, is_stop: bool = False) -> None:
        """Wait for a command, and handle meanwhile what is more urgent. Raises ValueError or RuntimeError.

        is_stop: whether the command is itself a stop, which no other one ends.
        """
        until_s, interruptions = time.monotonic() + COMMAND_S, self.interruptions
        while not wait([order], LOOK_S).done:
            if time.monotonic() > until_s:
                raise RuntimeError(f"{what}: had no effect within {COMMAND_S:g} s")
            self.meanwhile()
        order.result()
        if self.interruptions != interruptions and not is_stop:
            raise RuntimeError(f"{what}: the vehicle was stopped or disarmed meanwhile")

    def send(self, command: str, **arguments: Any) -> None:
        """Issue a command without waiting. A failure is logged. Raises ValueError."""
        self.begin(command, **arguments).add_done_callback(log_error)
