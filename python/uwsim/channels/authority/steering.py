"""Steering commands that arrive as messages, one kind of which is active at a time, and the loop for /cmd_vel."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.channels.authority.joint_motion import JointMotion
from uwsim.channels.authority.rights import Rights
from uwsim.channels.channel import Channel
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator, NotRunningError, Subscription
from uwsim.navigation.control.controller import Controller, VelocityHold
from uwsim.scenario.build.station import tethered_through
from uwsim.simulator.helm import Clock, Helm, Lease, Reason, Timeout
from uwsim.simulator.helm import Source as Rank
from uwsim.simulator.simulator import Simulator

CHECK_S = 0.05
CONTROL_S = 0.05
ONE_THRUSTER = "/command"
TOGETHER = ("cmd_thrusters", "cmd_fins", ONE_THRUSTER)
"""Name endings of channels that command thrusters or fins; see _beside."""

logger = logging.getLogger("uwsim.channels")


class Steering:
    """The door through which messages steer a vehicle: a command replaces the one before it, or the flight under way.

    Methods do not wait for the step at which a command takes effect. Failures are logged. helm: the vehicle's. shore:
    the helm that publishers hold; over a link it is another, because what steers aboard is not known ashore. by_keys:
    whether the current efforts came from the published keyboard. rights: the rights of clients other than the station's
    pilot, shared by all vehicles.

    A publisher holds the helm until another command replaces its own. If it publishes nothing for the vehicle's
    command_timeout_s, in simulated time, or leaves, the channel's `abandoned` is called. A timeout of 0 holds commands
    in both cases. Commands of channels without an idle message, such as the published wire's, end only when it leaves.
    """

    def __init__(self, source: Source, rights: Rights, helm: Helm, shore: Helm) -> None:
        self._source = source
        self.rights = rights
        self.helm = helm
        self.shore = shore
        self._loop: Subscription | None = None
        self._checks: Subscription | None = None
        self._loop_name = ""
        self._wanted = np.zeros(6)
        self.by_keys = False
        self._motion: JointMotion | None = None

    def apply(self, live: LiveSimulator, channel: Channel, message: Any, driver: str = "a client") -> None:
        """Apply a message that a client of this kind has published. May be called on any thread.

        Raises ValueError or RuntimeError.
        """
        self.rights.require(channel.name)
        with self.shore.lock:
            channel.apply(live, message)
            if channel.authority.abandoned is not None:
                self._renew(live, channel, driver)

    def _renew(self, live: LiveSimulator, channel: Channel, driver: str) -> None:
        """Take the helm for a publisher, or note that it still holds it."""
        lease = self._held_by(channel)
        if lease is None:
            if self._is_cut_off(live) or not self.shore.admits(Rank.CLIENT):  # the command was lost, or only stopped
                return
            lease = self.shore.take(Rank.CLIENT, channel.name, beside=_beside(channel.name))
        lease.driver = driver
        if channel.authority.idle is not None:
            limit_s = partial(self._source.command_timeout_s, live.simulator)
            then = partial(self._fall_silent, live, channel)
            lease.timeout = Timeout(Clock.SIMULATED, limit_s, then, live.time_ns)
            if self._checks is None:
                self._checks = live.every(CHECK_S, lambda sim: sim.time_ns, self._end_silent)

    def _held_by(self, channel: Channel) -> Lease | None:
        return next((lease for lease in self.shore.leases if lease.name == channel.name), None)

    @property
    def driver(self) -> str:
        """The kind of client whose command is in effect; "" if there is none."""
        return next((lease.driver for lease in self.shore.leases if lease.driver), "")

    def left(self, live: LiveSimulator, channel: Channel) -> None:
        """Note that a channel has lost its last publisher. May be called on any thread.

        Raises ValueError or RuntimeError.
        """
        with self.shore.lock:
            lease = self._held_by(channel)
            if lease is None or not lease.driver:
                return
            if channel.authority.idle is not None and self._source.command_timeout_s(live.simulator) == 0.0:
                return
            lease.driver, lease.timeout = "", None
        if channel.authority.abandoned is not None:
            channel.authority.abandoned(live)

    def _end_silent(self, now_ns: int) -> None:
        """End the commands of silent publishers, on the simulator's thread."""
        with self.shore.lock:
            timed = [(lease, lease.timeout) for lease in self.shore.leases if lease.timeout is not None]
            silent = [(lease, timeout) for lease, timeout in timed if not timeout.left_ns(now_ns)]
            for lease, _ in silent:
                lease.driver, lease.timeout = "", None
            if len(timed) == len(silent) and self._checks is not None:
                self._checks.cancel()
                self._checks = None
        for _, timeout in silent:
            timeout.then()

    def _fall_silent(self, live: LiveSimulator, channel: Channel) -> None:
        limit_s = self._source.command_timeout_s(live.simulator)
        logger.info("topic '%s': no command for %g s: it is stopped", channel.name, limit_s)
        try:
            if channel.authority.abandoned is not None:
                channel.authority.abandoned(live)
        except (ValueError, NotRunningError) as error:  # for example, an all stop has stopped it already
            logger.info("topic '%s': %s", channel.name, error)

    def forget(self) -> None:
        """Note that a command from ashore, other than a publisher's, has been sent over the link."""
        if self.shore is not self.helm:
            self.shore.clear(Reason.REPLACED)

    def ask(self, live: LiveSimulator, name: str, /, **arguments: Any) -> Future[Any]:
        """Issue a command that does not steer. The command is silently lost if a fault has cut the vehicle's link."""
        return nothing_done() if self._is_cut_off(live) else self._command(live, name, **arguments)

    def move_joints(self, motion: JointMotion | None) -> None:
        """Let joints follow a trajectory, which ends the one before it; None for another command of the joints."""
        with self.shore.lock:
            before, self._motion = self._motion, motion
        if before is not None:
            before.leave(Reason.REPLACED)
        if motion is not None:
            motion.start()

    def _is_cut_off(self, live: LiveSimulator) -> bool:
        return is_cut_off(live.simulator, self._source.name)

    def _command(self, live: LiveSimulator, name: str, /, **arguments: Any) -> Future[Any]:
        future = live.command(name, vehicle=self._source.name, **arguments)
        future.add_done_callback(log_error)
        return future

    def give(self, live: LiveSimulator, name: str, by: Rank = Rank.CLIENT, /, **arguments: Any) -> Future[Any]:
        """Issue a steering command of a source. Raises ValueError if it would move a vehicle that others steer."""
        if self._is_cut_off(live):
            return nothing_done()
        if self.shore is self.helm and _moves(arguments):  # over a link, the state aboard is unknown ashore
            self.helm.require_at_door(name, by)
        with self.helm.lock:
            self.by_keys = False
            self.helm.clear(Reason.REPLACED, beside=_beside(name))
            return self._command(live, name, **arguments)

    def fly(self, name: str, lose: Callable[[Reason], object]) -> Lease:
        """Take the helm for a flight that commands the vehicle itself; see Helm.take. Raises ValueError."""
        with self.helm.lock:
            lease = self.helm.take(Rank.FLIGHT, name, lose)
            self.forget()
            self.by_keys = False
        return lease

    @property
    def is_flown(self) -> bool:
        """True while a flight that commands the vehicle itself, or a velocity hold, is in effect."""
        is_held = self._loop is not None and not self._loop.cancelled
        return is_held or bool(self.helm.name_of(Rank.FLIGHT))

    def hold_velocity(self, live: LiveSimulator, velocity_body: NDArray[np.float64], name: str = "cmd_vel") -> None:
        """Hold a velocity (6,) [m/s, rad/s] in body axes, for a topic. Raises ValueError while others steer."""

        def loop(vehicle: Any) -> Callable[[], dict[str, float]]:
            hold = VelocityHold(vehicle, CONTROL_S)
            return lambda: hold.efforts(self._wanted)

        if self._is_cut_off(live):
            return
        with self.helm.lock:
            self.helm.require_at_door(name, Rank.CLIENT)
            self._wanted = velocity_body
            self.control(live, name, loop)

    def hold_place(
        self,
        live: LiveSimulator,
        position_world_m: NDArray[np.float64],
        heading_rad: float,
        memory: NDArray[np.float64],
        *,
        uses_truth: bool,
    ) -> None:
        """Keep a vehicle at a position (3,), until another command steers. Raises ValueError while others steer.

        memory: of the Controller that has flown it there, so that it does not drift first. uses_truth: whether the
        position is the true one, instead of the estimate.
        """

        def loop(vehicle: Any) -> Callable[[], dict[str, float]]:
            pilot = Controller(vehicle, CONTROL_S, estimate=None if uses_truth else vehicle.navigation.steering)
            pilot.memory = memory
            return lambda: dict(zip(AXES, pilot.hold_efforts(position_world_m, heading_rad), strict=True))

        self.control(live, "target", loop)

    def control(self, live: LiveSimulator, name: str, loop: Callable[[Any], Callable[[], dict[str, float]]]) -> None:
        """Set efforts every CONTROL_S, for a topic, until another command replaces them. Raises ValueError.

        loop: returns, for the vehicle, the function that returns the efforts; a loop of this name goes on.
        """
        if self._is_cut_off(live):
            return
        with self.helm.lock:
            self.helm.require_at_door(name, Rank.CLIENT)
            self.by_keys = False
            if self._loop is None or self._loop.cancelled or self._loop_name != name:
                self.helm.take(Rank.CLIENT, self._source.topic(name), self._end_loop)
                self._loop_name = name
                efforts = loop(live.simulator.vehicles[self._source.name])
                self._loop = live.every(CONTROL_S, lambda sim: efforts, lambda efforts: self._steer(live, efforts))

    def _steer(self, live: LiveSimulator, efforts: Callable[[], dict[str, float]]) -> None:
        """Set the efforts of one control period, on the simulator's thread."""
        found = efforts()
        with self.helm.lock:
            if self._loop is not None and not self._loop.cancelled:  # unless another source has taken the helm
                self._command(live, "set_effort", **found)

    def _end_loop(self, reason: Reason) -> None:
        if self._loop is not None:
            self._loop.cancel()


def _beside(name: str) -> tuple[str, ...]:
    """Return the endings of the channels whose commands stay in effect beside a command or a channel's.

    Both cmd_thrusters and the topics of single thrusters set all thrusters, so that they replace each other.
    """
    if name.endswith("cmd_thrusters"):
        return ("cmd_fins",)
    if name.endswith(ONE_THRUSTER):
        return ("cmd_fins", ONE_THRUSTER)
    return TOGETHER if name.endswith(("thrusters", "fins")) else ()


def _moves(arguments: Mapping[str, Any]) -> bool:
    """Return whether a steering command has any value other than zero."""
    return any(np.any(list(each.values()) if isinstance(each, Mapping) else each) for each in arguments.values())


def is_cut_off(sim: Simulator, vehicle: str) -> bool:
    """Return whether a fault or a broken tether, its own or one that leads to it, has cut off a vehicle.

    False in a scenario with a link, which loses packets instead.
    """
    if sim.link is not None:
        return False
    if sim.faults.link_is_down(vehicle):
        return True
    if not sim.tethers:  # asked for every message
        return False
    return any(sim.tethers[name].is_broken for name in tethered_through(sim.scenario, vehicle))


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
