"""Which peers of a door are half open, which have a place, and which must go; the same rule for all doors.

Where the peer speaks first, it is half open until it has sent something valid: a message, or a whole request. Half-open
peers go after HALF_OPEN_S, and never take a place. Where the door speaks first, a peer has a place, and is served, from
its connection on, for as long as it likes to listen. Places are bounded, and a newcomer always gets one: of those that
have never spoken, the first goes, and if all have, the one that has been silent longest. So no number of silent peers
can shut out another, whether it speaks or listens.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

HALF_OPEN_S = 5.0
HALF_OPEN_MAX = 64

Peer = TypeVar("Peer", bound=Hashable)


class HalfOpen(Generic[Peer]):
    """The half-open peers of one door. May be used on any thread.

    end: called with a peer that must go: the one that came first if there are more than `most`, and each that `sweep`
    finds older than HALF_OPEN_S.
    """

    def __init__(
        self,
        end: Callable[[Peer], object],
        most: int = HALF_OPEN_MAX,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._end, self._most, self._clock = end, most, clock
        self._came_s: dict[Peer, float] = {}  # in the order of arrival
        self._lock = threading.Lock()

    def __contains__(self, peer: Peer) -> bool:
        return peer in self._came_s

    def __len__(self) -> int:
        return len(self._came_s)

    def add(self, peer: Peer) -> None:
        """Note a new peer; the one that came first goes if there are too many."""
        with self._lock:
            self._came_s[peer] = self._clock()
            first = next(iter(self._came_s)) if len(self._came_s) > self._most else None
            if first is not None:
                del self._came_s[first]
        if first is not None:
            self._end(first)

    def discard(self, peer: Peer) -> None:
        """Forget a peer that is valid, or has gone."""
        with self._lock:
            self._came_s.pop(peer, None)

    def sweep(self) -> None:
        """End the peers that have been half open for too long."""
        with self._lock:
            oldest_s = self._clock() - HALF_OPEN_S
            late = [peer for peer, came_s in self._came_s.items() if came_s <= oldest_s]
            for peer in late:
                del self._came_s[peer]
        for peer in late:
            self._end(peer)


class Places(Generic[Peer]):
    """The peers with a place at one door. Must be used on one thread.

    end: called with a peer that must go: one that makes room if there are more than `most`, and each that `sweep` finds
    silent for silent_s.
    """

    def __init__(
        self,
        end: Callable[[Peer], object],
        most: int,
        silent_s: float = math.inf,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._end, self._most, self._silent_s, self._clock = end, most, silent_s, clock
        self._heard: dict[Peer, tuple[bool, float]] = {}  # whether it has spoken, and when it came or spoke last [s]

    def __contains__(self, peer: Peer) -> bool:
        return peer in self._heard

    def peers(self) -> list[Peer]:
        """Return the peers, in the order in which they would go."""
        return sorted(self._heard, key=self._heard.__getitem__)

    def admit(self, peer: Peer) -> None:
        """Give a place to a peer that has not spoken yet."""
        self._note(peer, has_spoken=False)

    def renew(self, peer: Peer) -> None:
        """Note that a peer has sent something valid, which gives it a place."""
        self._note(peer, has_spoken=True)

    def _note(self, peer: Peer, *, has_spoken: bool) -> None:
        self._heard[peer] = has_spoken, self._clock()
        if len(self._heard) > self._most:
            self._go(next(each for each in self.peers() if each != peer))

    def discard(self, peer: Peer) -> None:
        """Forget a peer that has gone."""
        self._heard.pop(peer, None)

    def sweep(self) -> None:
        """End the peers that have been silent for too long."""
        now_s = self._clock()
        for peer in [peer for peer, (_, heard_s) in self._heard.items() if now_s - heard_s >= self._silent_s]:
            self._go(peer)

    def _go(self, peer: Peer) -> None:
        del self._heard[peer]
        self._end(peer)
