"""Schedules the transmission of vehicle channels, as items on the simulator's agenda."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping

from uwsim.base.agenda import next_tick
from uwsim.channels.channel import PICTURE
from uwsim.link.carried import Carried

AGAIN_S = 0.25
"""Delay before a picture that was not ready, or had no reader, is checked again."""

Send = Callable[[str], bool]
"""A function that sends a channel's current message and returns whether there was one."""


class Turn:
    """One or several channels that take turns. names: starts with the channel whose turn is next."""

    def __init__(self, name: str, rate_hz: float, step_ns: int, send: Send) -> None:
        self.names = deque([name])
        self.due_tick = 0
        self._period_ns = max(round(1e9 / rate_hz), 1)
        self._again_ns = min(self._period_ns, round(AGAIN_S * 1e9))
        self._step_ns = step_ns
        self._send = send

    def act(self, tick: int) -> None:
        """Send the first channel that has a message."""
        is_sent = False
        for _ in range(len(self.names)):
            name = self.names[0]
            self.names.rotate(-1)
            if is_sent := self._send(name):
                break
        self.due_tick = next_tick(tick, self._period_ns if is_sent else self._again_ns, self._step_ns)

    def jump(self, tick: int) -> None:
        """Become due immediately, because simulated time has jumped."""
        self.due_tick = tick


def turns(
    carried: Mapping[str, Carried], rates: Mapping[str, float], step_s: float, send: Send, *, shared: bool
) -> list[Turn]:
    """Return the turns of all channels. rates: by channel [Hz]. shared: whether a vehicle's pictures take turns."""
    found: list[Turn] = []
    of_pictures: dict[str, Turn] = {}
    for name, rate_hz in rates.items():
        vehicle, is_picture = carried[name].vehicle, carried[name].priority == PICTURE
        if shared and is_picture and vehicle in of_pictures:
            of_pictures[vehicle].names.append(name)
            continue
        turn = Turn(name, rate_hz, round(step_s * 1e9), send)
        found.append(turn)
        if is_picture:
            of_pictures[vehicle] = turn
    return found
