"""Watch: reads a simulator's channels at their rates, at ticks that do not depend on how it is stepped."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from uwsim.base.agenda import NEVER, Rank, next_tick
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
    only at the start and after jumps. due_tick: when any channel is read next; all are one item of the agenda, which is
    asked at each step.
    """

    def __init__(
        self,
        sim: Simulator,
        channels: Iterable[Channel],
        receive: OnMessage,
        command: OnCommand | None = None,
        measured: AbstractContextManager[object] | None = None,
    ) -> None:
        """measured: entered around readings and commands, such as a stage's measurement."""
        self._sim = sim
        self._receive = receive
        self._command = command
        self._measured = measured or nullcontext()
        self._step_ns = round(sim.step_s * 1e9)
        self._subscriptions = [(_period_ns(channel), self._subscription(channel)) for channel in channels]
        self._due_ticks = dict.fromkeys((period_ns for period_ns, _ in self._subscriptions), NEVER)
        self._read_together: dict[tuple[int | None, ...], list[Subscription]] = {}
        self.due_tick = NEVER

    def start(self) -> None:
        """Read all channels now, and start watching. Call this on the simulator's thread."""
        self._read_all()
        self._sim.journal.listen(self)
        self._sim.agenda.add(self, Rank.OBSERVER, self.act)

    def stop(self) -> None:
        """Stop watching."""
        self._sim.journal.detach(self)
        self._sim.agenda.remove(self)

    def act(self, tick: int) -> None:
        """Read the channels that are due, in order."""
        self._read(tuple(period_ns for period_ns, due_tick in self._due_ticks.items() if due_tick <= tick), tick)

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Forward a command; after a jump in time, read all channels again."""
        if self._command is not None:
            with self._measured:
                self._command(name, arguments)
        if name in JUMPS:
            self._read_all()

    def _read_all(self) -> None:
        self._read(tuple(self._due_ticks), self._sim.tick)

    def _read(self, periods_ns: tuple[int | None, ...], tick: int) -> None:
        """Read all channels with these periods."""
        for period_ns in periods_ns:
            if period_ns is not None:
                self._due_ticks[period_ns] = next_tick(tick, period_ns, self._step_ns)
        self.due_tick = min(self._due_ticks.values(), default=NEVER)
        together = self._read_together.get(periods_ns)
        if together is None:
            together = [one for period_ns, one in self._subscriptions if period_ns in periods_ns]
            self._read_together[periods_ns] = together
        with self._measured:
            for one in together:
                one.take(tick)

    def _subscription(self, channel: Channel) -> Subscription:
        def receive(message: Any) -> None:
            if message is not None:
                self._receive(channel, message)

        return Subscription(self._sim, _period_ns(channel), channel.read, receive)


def _period_ns(channel: Channel) -> int | None:
    return None if channel.rate_hz is None else max(round(1e9 / channel.rate_hz), 1)
