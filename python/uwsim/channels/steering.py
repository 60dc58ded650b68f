"""Steering commands that arrive as messages, one kind of which is active at a time, and the loop for /cmd_vel."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.rights import Rights
from uwsim.channels.source import Source
from uwsim.channels.watchdog import Watchdog
from uwsim.live import LiveSimulator, Subscription
from uwsim.navigation.control.velocity_hold import VelocityHold
from uwsim.simulator.command_gate import CommandGate
from uwsim.simulator.simulator import Simulator

CONTROL_S = 0.05
REPLACED = "another command has taken its place"

logger = logging.getLogger("uwsim.channels")


class Steering:
    """Applies the last effort, wrench or thruster command to a vehicle, or holds a velocity until the next command.

    Methods do not wait for the step at which a command takes effect. Failures are logged. by_keys: whether the current
    efforts came from the published keyboard. watch: ends commands whose publisher has fallen silent. rights: the rights
    of clients other than the station's pilot, shared by all vehicles.
    """

    def __init__(self, source: Source, rights: Rights) -> None:
        self._source = source
        self.rights = rights
        self._lock = threading.Lock()
        self._loop: Subscription | None = None
        self._stops = 0  # the gate's count of all stops when the loop began
        self._wanted = np.zeros(6)
        self.by_keys = False
        self._replaced: Callable[[], object] | None = None
        self.watch = Watchdog(source.command_timeout_s)

    def ask(self, live: LiveSimulator, name: str, **arguments: Any) -> Future[Any]:
        """Issue a command that does not steer. The command is silently lost if a fault has cut the vehicle's link."""
        return nothing_done() if self._is_cut_off(live) else self._command(live, name, **arguments)

    def _is_cut_off(self, live: LiveSimulator) -> bool:
        return is_cut_off(live.simulator, self._source.name)

    def _command(self, live: LiveSimulator, name: str, **arguments: Any) -> Future[Any]:
        future = live.command(name, vehicle=self._source.name, **arguments)
        future.add_done_callback(log_error)
        return future

    def give(self, live: LiveSimulator, name: str, **arguments: Any) -> Future[Any]:
        """Issue a steering command and end any velocity hold. Raises ValueError while all stop is set."""
        if self._is_cut_off(live):
            return nothing_done()
        if live.simulator.link is None and _moves(arguments):  # over a link, the state aboard is unknown here
            self._gate(live).require_no_stop(name)
        with self._lock:
            self._replace()
            return self._command(live, name, **arguments)

    def begin_flight(self, replaced: Callable[[], object]) -> None:
        """Begin a flight that commands the vehicle itself, ending any velocity hold or earlier flight.

        replaced: called on any thread when another command replaces the flight. It must not block.
        """
        self.watch.forget()
        with self._lock:
            self._replace()
            self._replaced = replaced

    def in_flight(self, replaced: Callable[[], object], command: Callable[[], Future[Any]]) -> Future[Any]:
        """Issue a flight's command. Raises RuntimeError if another command has replaced the flight."""
        with self._lock:
            if self._replaced != replaced:
                raise RuntimeError(REPLACED)
            return command()

    def end_flight(self, replaced: Callable[[], object]) -> bool:
        """Note that a flight has ended; return whether it was still in effect."""
        with self._lock:
            was_in_effect = self._replaced == replaced
            if was_in_effect:
                self._replaced = None
            return was_in_effect

    def _replace(self) -> None:
        """End the velocity hold or flight that is in effect."""
        self.by_keys = False
        if self._loop is not None:
            self._loop.cancel()
            self._loop = None
        replaced, self._replaced = self._replaced, None
        if replaced is not None:
            replaced()

    def hold_velocity(self, live: LiveSimulator, velocity_body: NDArray[np.float64]) -> None:
        """Hold a velocity (6,) [m/s, rad/s] in body axes. Raises ValueError while all stop is set."""
        if self._is_cut_off(live):
            return
        gate = self._gate(live)
        gate.require_no_stop("cmd_vel")
        with self._lock:
            if self._replaced is not None:
                self._replace()
            self._wanted = velocity_body
            self.by_keys = False
            self._end_if_stopped(gate)
            if self._loop is None or self._loop.cancelled:
                self._stops = gate.stops
                hold = VelocityHold(live.simulator.vehicles[self._source.name], CONTROL_S)
                self._loop = live.every(CONTROL_S, lambda sim: hold, lambda hold: self._steer(live, hold))

    def _steer(self, live: LiveSimulator, hold: VelocityHold) -> None:
        """Set the efforts of one control period, on the simulator's thread."""
        efforts = hold.efforts(self._wanted)
        with self._lock:
            self._end_if_stopped(self._gate(live))
            if self._loop is not None:  # unless another command has arrived in the meantime
                self._command(live, "set_effort", **efforts)

    def _gate(self, live: LiveSimulator) -> CommandGate:
        return live.simulator.vehicles[self._source.name].gate

    def _end_if_stopped(self, gate: CommandGate) -> None:
        """End the velocity hold if all stop has been set since the hold began, even if it was released again."""
        if self._loop is not None and gate.stops != self._stops:
            self._loop.cancel()
            self._loop = None


def _moves(arguments: Mapping[str, Any]) -> bool:
    """Return whether a steering command has any value other than zero."""
    return any(np.any(list(each.values()) if isinstance(each, Mapping) else each) for each in arguments.values())


def is_cut_off(sim: Simulator, vehicle: str) -> bool:
    """Return whether a fault has cut off a vehicle; False in a scenario with a link, which loses packets instead."""
    return sim.link is None and sim.faults.link_is_down(vehicle)


def require_link(live: LiveSimulator, vehicle: str, command: str) -> None:
    """Raise ValueError while a fault has cut off a vehicle, since it could not respond."""
    if is_cut_off(live.simulator, vehicle):
        raise ValueError(f"{command}: no answer: the link to '{vehicle}' is down")


def nothing_done() -> Future[Any]:
    """Return a completed future for a lost command, because its sender cannot know that it was lost."""
    future: Future[Any] = Future()
    future.set_result(None)
    return future


def log_error(future: Future[Any]) -> None:
    """Log the error, if any, of a command whose result is not awaited."""
    error = None if future.cancelled() else future.exception()
    if error is not None:
        logger.error("a command failed: %s", error)
