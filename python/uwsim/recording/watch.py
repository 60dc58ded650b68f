"""Watch: reads the channels of a simulator at their rates, at the same ticks however the simulator is driven."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from uwsim.channels import Channel
from uwsim.live import Subscription
from uwsim.simulator import Simulator

JUMPS = ("reset", "restore_state")
"""Commands after which every channel is read anew."""
NEVER_NS = 10**18  # thirty years of simulated time

TakeMessage = Callable[[Channel, Any], object]
TakeCommand = Callable[[str, dict[str, Any]], object]


class Watch:
    """An observer that hands on each message of the channels, and each command, in the order in which they happen.

    Channels are read when `start` is called, after each jump of time and at all multiples of their period; what a tick
    says is read before the commands of that tick. So a replay reads the same at the same ticks. A channel without a
    rate is read at the start and after jumps alone.
    """

    def __init__(
        self, sim: Simulator, channels: Iterable[Channel], take: TakeMessage, command: TakeCommand | None = None
    ) -> None:
        self._sim = sim
        self._take = take
        self._command = command
        self._subscriptions = [self._subscription(channel) for channel in channels]

    def start(self) -> None:
        """Read all channels now, and watch from now on. On the simulator's thread."""
        self._read_anew()
        self._sim.journal.attach(self)

    def stop(self) -> None:
        """Watch no more."""
        self._sim.journal.detach(self)

    @property
    def due_tick(self) -> int:
        """The next tick at which a channel is due."""
        return min((subscription.due_tick for subscription in self._subscriptions), default=NEVER_NS)

    def observe(self) -> None:
        """Read the channels that are due."""
        tick = self._sim.tick
        for subscription in self._subscriptions:
            if subscription.due_tick <= tick:
                subscription.deliver(self._sim, tick)

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Hand a command on; after a jump of time read everything anew."""
        if self._command is not None:
            self._command(name, arguments)
        if name in JUMPS:
            self._read_anew()

    def _read_anew(self) -> None:
        tick = self._sim.tick
        for subscription in self._subscriptions:
            subscription.due_tick = tick
        self.observe()

    def _subscription(self, channel: Channel) -> Subscription:
        period_ns = NEVER_NS if channel.rate_hz is None else max(round(1e9 / channel.rate_hz), 1)
        step_ns = round(self._sim.step_s * 1e9)

        def take(message: Any) -> None:
            if message is not None:
                self._take(channel, message)

        return Subscription(period_ns, step_ns, channel.read, take, self._sim.tick)
