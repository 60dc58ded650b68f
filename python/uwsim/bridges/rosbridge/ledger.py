"""The bytes stored for clients: for each of them and for all together, both bounded."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol


class Held(Protocol):
    """An object that may be queued for several clients, but is in memory once."""

    holders: int

    @property
    def size(self) -> int:
        """Return its size in bytes, which does not change."""


class Ledger:
    """The total stored for all clients. limit: bytes beyond which the client with the most is disconnected."""

    def __init__(self, limit: float = math.inf) -> None:
        self.limit = limit
        self.bytes = 0
        self.accounts: set[Account] = set()

    def relieve(self) -> None:
        """Close the largest account if the total is too large."""
        if self.bytes > self.limit and self.accounts:
            largest = max(self.accounts, key=lambda account: account.bytes)
            largest.give_up(
                f"{self.bytes / 1e6:.0f} MB wait for all clients, which may be {self.limit / 1e6:.0f}; "
                f"{largest.bytes / 1e6:.0f} MB of them are yours"
            )


class Account:
    """The bytes stored for one client. limit: their maximum. give_up: called with the reason if the client must go."""

    def __init__(self, ledger: Ledger, limit: float, give_up: Callable[[str], None]) -> None:
        self.limit = limit
        self.bytes = 0
        self.give_up = give_up
        self._own = 0  # the part of the bytes that no other client shares
        self._is_closed = False
        self._ledger = ledger
        ledger.accounts.add(self)

    @property
    def is_over(self) -> bool:
        """Whether more is stored than allowed."""
        return self.bytes > self.limit

    def has_room(self, size: int) -> bool:
        """Return whether this many more bytes may be stored, for this client and for all."""
        return self.bytes + size <= self.limit and self._ledger.bytes + size <= self._ledger.limit

    def take(self, size: int) -> None:
        """Count bytes that are stored from now on."""
        if self._is_closed:
            return
        self.bytes += size
        self._own += size
        self._ledger.bytes += size
        self._ledger.relieve()

    def give(self, size: int) -> None:
        """Count bytes that are no longer stored."""
        if self._is_closed:
            return
        self.bytes -= size
        self._own -= size
        self._ledger.bytes -= size

    def hold(self, held: Held) -> None:
        """Count an object that other clients may hold as well: in the total it counts once."""
        self.bytes += held.size
        if held.holders == 0:
            self._ledger.bytes += held.size
        held.holders += 1
        self._ledger.relieve()

    def drop(self, held: Held) -> None:
        """Stop counting it."""
        self.bytes -= held.size
        held.holders -= 1
        if held.holders == 0:
            self._ledger.bytes -= held.size

    def close(self) -> None:
        """Return everything that was taken, and stop counting; held objects can be dropped later."""
        self.give(self._own)
        self._is_closed = True
        self.give_up = _stay  # so that the account does not keep its client in memory
        self._ledger.accounts.discard(self)


def _stay(reason: str) -> None:
    """Do nothing: the client is leaving already."""
