"""When each channel of the vehicles is due to be sent."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from uwsim.channels.channel import PICTURE
from uwsim.link.carried import Carried

AGAIN_S = 0.25
"""After which a picture that was not ready, or that nobody listened for, is looked for again."""


@dataclass
class Turn:
    """Channels that take turns, or one alone. names: the next one first."""

    names: deque[str]
    rate_hz: float
    due_tick: int = 0


class Schedule:
    """The turns of all channels, in simulated time. Over a modem the pictures of a vehicle share one turn."""

    def __init__(self, carried: Mapping[str, Carried], rates: Mapping[str, float], step_s: float, *, shared: bool):
        """rates: of each channel [Hz]. shared: whether pictures share a turn."""
        self._step_ns = round(step_s * 1e9)
        pictures: dict[str, Turn] = {}
        self._turns: list[Turn] = []
        for name, rate_hz in rates.items():
            one = carried[name]
            if shared and one.channel.priority == PICTURE and one.vehicle in pictures:
                pictures[one.vehicle].names.append(name)
                continue
            turn = Turn(deque([name]), rate_hz)
            self._turns.append(turn)
            if one.channel.priority == PICTURE:
                pictures[one.vehicle] = turn

    @property
    def due_ticks(self) -> Iterable[int]:
        """The tick at which each turn is next."""
        return (turn.due_tick for turn in self._turns)

    def save(self) -> list[list[Any]]:
        """Return each turn's names in their order, and when it is next."""
        return [[list(turn.names), turn.due_tick] for turn in self._turns]

    def restore(self, turns: list[list[Any]]) -> None:
        """Go on from what `save` returned."""
        for turn, (names, due_tick) in zip(self._turns, turns, strict=True):
            turn.names, turn.due_tick = deque(names), due_tick

    def restart(self, tick: int) -> None:
        """Begin anew: everything is due at this tick."""
        for turn in self._turns:
            turn.due_tick = tick

    def take(self, tick: int, say: Callable[[str], bool]) -> None:
        """Say what is due. say(name): whether there was something to say."""
        for turn in self._turns:
            if turn.due_tick > tick:
                continue
            said = False
            for _ in range(len(turn.names)):
                name = turn.names[0]
                turn.names.rotate(-1)
                if said := say(name):
                    break
            again = not said and 1.0 / turn.rate_hz > AGAIN_S
            turn.due_tick = self._next_tick(tick, 1.0 / AGAIN_S if again else turn.rate_hz)

    def _next_tick(self, tick: int, rate_hz: float) -> int:
        """Return the first tick at or after the next multiple of the period."""
        period_ns = max(round(1e9 / rate_hz), 1)
        periods = tick * self._step_ns // period_ns + 1
        return max(-(-periods * period_ns // self._step_ns), tick + 1)
