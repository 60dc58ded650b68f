"""Watch: reads a simulator's channels at their rates, at ticks that do not depend on how it is stepped."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from uwsim.base.agenda import Rank
from uwsim.base.journal import JUMPS
from uwsim.channels import Channel
from uwsim.live import Subscription
from uwsim.simulator.simulator import Simulator

OnMessage = Callable[[Channel, Any], object]
OnCommand = Callable[[str, dict[str, Any]], object]


class Watch:
    """Forwards all messages on the channels, and all commands, in order.

    Channels are read when `start` is called, after each jump in time and at all multiples of their period, before the
    commands of that tick, so that a replay reads the same messages at the same ticks. A channel without a rate is read
    only at the start and after jumps.
    """

    def __init__(
        self, sim: Simulator, channels: Iterable[Channel], receive: OnMessage, command: OnCommand | None = None
    ) -> None:
        self._sim = sim
        self._receive = receive
        self._command = command
        self._subscriptions = [self._subscription(channel) for channel in channels]

    def start(self) -> None:
        """Read all channels now, and start watching. Call this on the simulator's thread."""
        self._read_all()
        self._sim.journal.listen(self)
        for subscription in self._subscriptions:
            self._sim.agenda.add(subscription, Rank.OBSERVER, subscription.act)

    def stop(self) -> None:
        """Stop watching."""
        self._sim.journal.detach(self)
        for subscription in self._subscriptions:
            subscription.cancel()

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Forward a command; after a jump in time, read all channels again."""
        if self._command is not None:
            self._command(name, arguments)
        if name in JUMPS:
            self._read_all()

    def _read_all(self) -> None:
        for subscription in self._subscriptions:
            subscription.act(self._sim.tick)

    def _subscription(self, channel: Channel) -> Subscription:
        def receive(message: Any) -> None:
            if message is not None:
                self._receive(channel, message)

        period_ns = None if channel.rate_hz is None else max(round(1e9 / channel.rate_hz), 1)
        return Subscription(self._sim, period_ns, channel.read, receive)
