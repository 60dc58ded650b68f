"""Accounts for the bytes stored for clients, which are bounded both per client and in total."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol


class Held(Protocol):
    """An object that is in memory only once, even if it is queued for several clients."""

    holders: int

    @property
    def size(self) -> int:
        """The object's size in bytes. It does not change."""


class Ledger:
    """The total stored for all clients. limit: the number of bytes beyond which the largest client is disconnected."""

    def __init__(self, limit: float = math.inf) -> None:
        self.limit = limit
        self.bytes = 0
        self.accounts: set[Account] = set()

    def relieve(self) -> None:
        """Disconnect the client with the largest account if the total is too large."""
        if self.bytes > self.limit and self.accounts:
            largest = max(self.accounts, key=lambda account: account.bytes)
            largest.give_up(
                f"{self.bytes / 1e6:.0f} MB wait for all clients, which may be {self.limit / 1e6:.0f}; "
                f"{largest.bytes / 1e6:.0f} MB of them are yours"
            )


class Account:
    """The bytes stored for one client. limit: the maximum. give_up: disconnects the client for the reason passed."""

    def __init__(self, ledger: Ledger, limit: float, give_up: Callable[[str], None]) -> None:
        self.limit = limit
        self.bytes = 0
        self.give_up = give_up
        self._own = 0  # the part of the bytes not shared with other clients
        self._is_closed = False
        self._ledger = ledger
        ledger.accounts.add(self)

    @property
    def is_over(self) -> bool:
        """Whether more bytes are stored than allowed."""
        return self.bytes > self.limit

    def has_room(self, size: int) -> bool:
        """Return whether this many more bytes may be stored, for this client and in total."""
        return self.bytes + size <= self.limit and self._ledger.bytes + size <= self._ledger.limit

    def take(self, size: int) -> None:
        """Add bytes that are stored from now on."""
        if self._is_closed:
            return
        self.bytes += size
        self._own += size
        self._ledger.bytes += size
        self._ledger.relieve()

    def give(self, size: int) -> None:
        """Subtract bytes that are no longer stored."""
        if self._is_closed:
            return
        self.bytes -= size
        self._own -= size
        self._ledger.bytes -= size

    def hold(self, held: Held) -> None:
        """Count an object that other clients may also hold. The total counts such an object only once."""
        self.bytes += held.size
        if held.holders == 0:
            self._ledger.bytes += held.size
        held.holders += 1
        self._ledger.relieve()

    def drop(self, held: Held) -> None:
        """Stop counting an object."""
        self.bytes -= held.size
        held.holders -= 1
        if held.holders == 0:
            self._ledger.bytes -= held.size

    def close(self) -> None:
        """Release everything taken, and stop counting. Held objects can still be dropped later."""
        self.give(self._own)
        self._is_closed = True
        self.give_up = _stay  # so that the account does not keep its client in memory
        self._ledger.accounts.discard(self)


def _stay(reason: str) -> None:
    """Do nothing, because the client is already leaving."""
