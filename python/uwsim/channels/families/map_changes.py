"""The occupied voxels of a growing map, stored as blocks of bits, and their changes, for live views."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping import OccupancyChanges

EDGE = 16  # voxels along a block's edge
REMEMBERED = 400  # a reader that lacks more changes gets a snapshot instead
OCCUPIED = 0x8000


class Part(NamedTuple):
    """The fields of a MapChanges message, without its header."""

    sequence: int
    snapshot: bool
    resolution: float
    blocks: NDArray[np.int16]
    counts: NDArray[np.uint16]
    cells: NDArray[np.uint16]


class MapChanges:
    """Records changes on one thread, and provides readers on other threads with the changes that they lack.

    A reader's cursor is the number of changes that it has received.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._resolution_m = 0.0
        self._sequence = 0
        self._oldest = 0  # the last change that is no longer remembered
        self._remembered: deque[Part] = deque()
        self._rows: dict[tuple[int, int, int], int] = {}
        self._bits = np.zeros((0, EDGE**3 // 8), np.uint8)

    def forget(self, resolution_m: float) -> None:
        """Start over with an empty map; readers will get a snapshot."""
        with self._lock:
            self._restart(resolution_m)

    def note(self, changes: OccupancyChanges) -> Part:
        """Record the changes to the map since the last call, and return them as the fields of a message."""
        blocks, counts, cells = in_blocks(changes)
        with self._lock:
            return self._add(Part(0, False, self._resolution_m, blocks.ravel(), counts, cells))

    def apply(self, part: Part) -> None:
        """Apply the changes in one message; a snapshot replaces the current state."""
        with self._lock:
            if part.snapshot or part.resolution != self._resolution_m:
                self._restart(part.resolution)
            self._add(part)

    def _restart(self, resolution_m: float) -> None:
        self._resolution_m = resolution_m
        self._sequence += 1
        self._oldest = self._sequence
        self._remembered.clear()
        self._rows.clear()
        self._bits[:] = 0

    def _add(self, part: Part) -> Part:
        self._sequence += 1
        part = part._replace(sequence=self._sequence, snapshot=False)
        self._mark(part.blocks.reshape(-1, 3), part.counts, part.cells)
        self._remembered.append(part)
        if len(self._remembered) > REMEMBERED:
            self._remembered.popleft()
            self._oldest += 1
        return part

    def since(self, cursor: int | None) -> tuple[Part, int]:
        """Return the changes since `cursor`, and the next cursor."""
        with self._lock:
            if cursor is None or not self._oldest <= cursor <= self._sequence:
                return self._snapshot(), self._sequence
            parts = [part for part in self._remembered if part.sequence > cursor]
            joined = (np.concatenate([getattr(p, name) for p in parts] or [empty]) for name, empty in _EMPTY.items())
            return Part(self._sequence, False, self._resolution_m, *joined), self._sequence

    def _mark(self, blocks: NDArray[np.int16], counts: NDArray[np.uint16], cells: NDArray[np.uint16]) -> None:
        rows = np.repeat([self._row((x, y, z)) for x, y, z in blocks.tolist()], counts)
        at, now = cells & (OCCUPIED - 1), cells >= OCCUPIED
        bits = np.uint8(1) << (at & 7).astype(np.uint8)
        if len(rows):
            np.bitwise_or.at(self._bits, (rows[now], at[now] >> 3), bits[now])
            np.bitwise_and.at(self._bits, (rows[~now], at[~now] >> 3), ~bits[~now])

    def _row(self, block: tuple[int, int, int]) -> int:
        row = self._rows.setdefault(block, len(self._rows))
        if row == len(self._bits):
            more = np.zeros((max(64, 2 * row), self._bits.shape[1]), np.uint8)
            more[:row] = self._bits
            self._bits = more
        return row

    def _snapshot(self) -> Part:
        blocks = np.array(list(self._rows), np.int16).reshape(-1, 3)
        rows, cells = np.nonzero(np.unpackbits(self._bits[: len(blocks)], axis=1, bitorder="little"))
        counts = np.bincount(rows, minlength=len(blocks))
        some = counts > 0
        return Part(
            self._sequence,
            True,
            self._resolution_m,
            blocks[some].ravel(),
            counts[some].astype(np.uint16),
            (cells | OCCUPIED).astype(np.uint16),
        )


_EMPTY = {"blocks": np.zeros(0, np.int16), "counts": np.zeros(0, np.uint16), "cells": np.zeros(0, np.uint16)}


def in_blocks(changes: OccupancyChanges) -> tuple[NDArray[np.int16], NDArray[np.uint16], NDArray[np.uint16]]:
    """Convert changes in Morton order to the fields of the message: blocks (n, 3), counts (n,) and cells."""
    blocks, inside = changes.cells >> 4, (changes.cells & 15).astype(np.uint16)
    cells = inside[:, 0] | inside[:, 1] << 4 | inside[:, 2] << 8 | np.where(changes.occupied, OCCUPIED, 0)
    begins = np.flatnonzero(np.r_[len(blocks) > 0, (blocks[1:] != blocks[:-1]).any(axis=1)])
    counts = np.diff(np.r_[begins, len(blocks)])
    return blocks[begins], counts.astype(np.uint16), cells.astype(np.uint16)
