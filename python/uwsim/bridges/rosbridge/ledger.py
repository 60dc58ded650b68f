"""The bytes that are kept for clients: for each of them and for all together, both bounded."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol


class Held(Protocol):
    """What may wait for several clients at once, and is in memory once."""

    holders: int

    @property
    def size(self) -> int:
        """Return its bytes, which do not change."""


class Ledger:
    """What is kept for all clients. limit: bytes beyond which the client with most of them is disconnected."""

    def __init__(self, limit: float = math.inf) -> None:
        self.limit = limit
        self.bytes = 0
        self.accounts: set[Account] = set()

    def relieve(self) -> None:
        """Close the largest account if too much is kept."""
        if self.bytes > self.limit and self.accounts:
            largest = max(self.accounts, key=lambda account: account.bytes)
            largest.give_up(
                f"{self.bytes / 1e6:.0f} MB wait for all clients, which may be {self.limit / 1e6:.0f}; "
                f"{largest.bytes / 1e6:.0f} MB of them are yours"
            )


class Account:
    """What is kept for one client. limit: the most bytes of it. give_up: called with the reason if it must go."""

    def __init__(self, ledger: Ledger, limit: float, give_up: Callable[[str], None]) -> None:
        self.limit = limit
        self.bytes = 0
        self.give_up = give_up
        self._own = 0  # of the bytes, those that no other client shares
        self._is_closed = False
        self._ledger = ledger
        ledger.accounts.add(self)

    @property
    def is_over(self) -> bool:
        """Whether more is kept than may be."""
        return self.bytes > self.limit

    def has_room(self, size: int) -> bool:
        """Return whether so many bytes more may be kept, for this client and for all."""
        return self.bytes + size <= self.limit and self._ledger.bytes + size <= self._ledger.limit

    def take(self, size: int) -> None:
        """Count bytes that are kept from now on."""
        if self._is_closed:
            return
        self.bytes += size
        self._own += size
        self._ledger.bytes += size
        self._ledger.relieve()

    def give(self, size: int) -> None:
        """Count bytes that are kept no longer."""
        if self._is_closed:
            return
        self.bytes -= size
        self._own -= size
        self._ledger.bytes -= size

    def hold(self, held: Held) -> None:
        """Count what other clients may hold, too: for all it counts once."""
        self.bytes += held.size
        if held.holders == 0:
            self._ledger.bytes += held.size
        held.holders += 1
        self._ledger.relieve()

    def drop(self, held: Held) -> None:
        """Hold it no longer."""
        self.bytes -= held.size
        held.holders -= 1
        if held.holders == 0:
            self._ledger.bytes -= held.size

    def close(self) -> None:
        """Give back all that was taken, and count no more; what is held can be dropped later."""
        self.give(self._own)
        self._is_closed = True
        self.give_up = _stay  # lest the account keep its client in memory
        self._ledger.accounts.discard(self)


def _stay(reason: str) -> None:
    """Do nothing: the client is going already."""
