"""Watchdog: stops a vehicle when the publisher of its commands falls silent or leaves."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from uwsim.channels.channel import Channel
from uwsim.live import LiveSimulator, NotRunningError, Subscription
from uwsim.simulator.simulator import Simulator

CHECK_S = 0.05
TOGETHER = ("cmd_thrusters", "cmd_fins")
"""Name endings of channels whose commands do not replace each other."""

logger = logging.getLogger("uwsim.channels")


class Watchdog:
    """Monitors the command channels of one vehicle. All bridges report the commands that they apply.

    A channel's command is in effect until a command of another kind replaces it. If the channel receives no further
    command for timeout_s simulated seconds, or loses its last publisher, its `abandoned` is called. timeout_s: returns
    the limit, or 0 to hold commands in both cases. Commands of channels without a limit, such as the published wire's,
    are never ended by silence. driver: the kind of client whose command is in effect, such as "a rosbridge client".
    """

    def __init__(self, timeout_s: Callable[[Simulator], float]) -> None:
        self._timeout_s = timeout_s
        self._lock = threading.Lock()
        self._since_ns: dict[str, tuple[Channel, int]] = {}  # time of the last command, by channel in effect
        self._driver = ""
        self._checks: Subscription | None = None

    @property
    def driver(self) -> str:
        """The kind of client whose command is in effect; "" if there is none."""
        return self._driver if self._since_ns else ""

    def commanded(self, live: LiveSimulator, channel: Channel, driver: str = "a client") -> None:
        """Record that a channel's command from this kind of client has been applied. May be called on any thread."""
        with self._lock:
            self._driver = driver
            together = channel.name.endswith(TOGETHER)
            self._since_ns = {
                name: entry for name, entry in self._since_ns.items() if together and name.endswith(TOGETHER)
            }
            self._since_ns[channel.name] = channel, live.time_ns
            if self._checks is None and channel.has_timeout:
                self._checks = live.every(CHECK_S, lambda sim: sim.time_ns, lambda now_ns: self._check(live, now_ns))

    def left(self, live: LiveSimulator, channel: Channel) -> None:
        """Record that a channel no longer has a publisher. May be called on any thread.

        Raises ValueError or RuntimeError.
        """
        with self._lock:
            is_in_effect = channel.name in self._since_ns
            if not is_in_effect or (channel.has_timeout and self._timeout_s(live.simulator) == 0.0):
                return
            del self._since_ns[channel.name]
        _stop(live, channel)

    def forget(self) -> None:
        """Record that a command from elsewhere has replaced the channels' commands."""
        with self._lock:
            self._since_ns = {}

    def _check(self, live: LiveSimulator, now_ns: int) -> None:
        """End the commands of silent channels, on the simulator's thread.

        Times in the future are from before a reset.
        """
        timeout_ns = round(1e9 * self._timeout_s(live.simulator))
        with self._lock:
            timed = [entry for entry in self._since_ns.values() if entry[0].has_timeout]
            silent = [channel for channel, since in timed if timeout_ns and not since <= now_ns < since + timeout_ns]
            for channel in silent:
                del self._since_ns[channel.name]
            if len(timed) == len(silent) and self._checks is not None:
                self._checks.cancel()
                self._checks = None
        for channel in silent:
            logger.info("topic '%s': no command for %g s: it is stopped", channel.name, 1e-9 * timeout_ns)
            try:
                _stop(live, channel)
            except (ValueError, NotRunningError) as error:  # for example, an all stop has stopped it already
                logger.info("topic '%s': %s", channel.name, error)


def _stop(live: LiveSimulator, channel: Channel) -> None:
    if channel.abandoned is not None:
        channel.abandoned(live)
