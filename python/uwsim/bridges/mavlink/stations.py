"""The station whose sticks steer: the first that arms, until it is silent or the vehicle is disarmed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from uwsim.bridges.mavlink.component import CRITICAL_TEXT, SendText
from uwsim.bridges.mavlink.settings import Settings

Sender = tuple[int, int]
"""A station's system and component."""
NOTHING, WARN, DISARM, HOLD_DEPTH, SURFACE = range(5)
"""Values of FS_GCS_ENABLE: what follows when the station that owns the sticks falls silent while it is armed."""


def sender_of(message: Any) -> Sender:
    """Return the station that has sent a message."""
    return message.get_srcSystem(), message.get_srcComponent()


class Stations:
    """The station that owns the sticks. Time is that of the wall clock. Must be used on one thread."""

    def __init__(self, settings: Settings, send_text: SendText, now_s: Callable[[], float] = time.monotonic) -> None:
        self._settings, self._send_text, self._now_s = settings, send_text, now_s
        self.owner: Sender | None = None
        self._heard_s = 0.0
        self._refused: set[Sender] = set()

    def give_to(self, owner: Sender | None) -> None:
        """Make a station the owner; None: there is no owner."""
        self.owner, self._heard_s = owner, self._now_s()
        self._refused.clear()

    def hear(self, sender: Sender) -> None:
        """Note that a station is there, by any of its messages."""
        if sender == self.owner:
            self._heard_s = self._now_s()

    def require(self, sender: Sender, what: str) -> bool:
        """Return whether a station may use the sticks now; report the first refusal of each."""
        if self.owner is None:
            self.give_to(sender)
        elif sender != self.owner and sender not in self._refused:
            self._refused.add(sender)
            self._send_text(f"{what}: system {sender[0]}: refused: system {self.owner[0]} has the sticks")
        return sender == self.owner

    def silent_action(self) -> int:
        """Return NOTHING, or once the owner has fallen silent, which ends its ownership, what follows."""
        limit_s = self._settings["FS_GCS_TIMEOUT"]
        if self.owner is None or self._now_s() - self._heard_s <= limit_s:
            return NOTHING
        action = int(self._settings["FS_GCS_ENABLE"])
        if action != NOTHING:
            self._send_text(f"station {self.owner[0]} is silent for {limit_s:g} s", CRITICAL_TEXT)
        self.give_to(None)
        return action
