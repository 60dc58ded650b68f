"""Desk: moves large tasks from the network thread to another thread, where they run one at a time.

The network thread serves all clients, so it must not be blocked for long; and of large frames, only one is decoded in
memory at a time.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import TypeVar

from uwsim.bridges.doors.conversation import Allowance, Frame
from uwsim.bridges.rosbridge.outbox import Parcel
from uwsim.bridges.rosbridge.session import Session

LARGE_FRAME_BYTES = 1 << 13
# CPU time charged in advance for a large frame; the difference from the actual time is settled afterwards
S_PER_BYTE = 5e-8

T = TypeVar("T")


class Desk:
    """Runs work on `pool`. share: limits the total CPU time for all clients."""

    def __init__(self, share: Allowance, pool: Executor) -> None:
        self._share = share
        self._pool = pool

    async def do(self, work: Callable[[], T], size: int) -> T:
        """Run work off the network thread, once work on this many bytes fits within the CPU share."""
        expected_s = S_PER_BYTE * size
        await asyncio.sleep(self._share.delay_after(expected_s))
        result, worked_s = await asyncio.get_running_loop().run_in_executor(self._pool, _timed, work)
        self._share.delay_after(worked_s - expected_s)
        return result

    async def encode(self, parcel: Parcel) -> Frame:
        """Return the frame for a due message. Encoding published messages is not charged to the clients."""
        if not parcel.sample.is_large:
            return parcel.encode()
        return await asyncio.get_running_loop().run_in_executor(self._pool, parcel.encode)


class Seat:
    """A client session whose small frames are handled on the network thread and whose large ones go to the desk."""

    def __init__(self, session: Session, desk: Desk) -> None:
        self.session = session
        self._desk = desk

    async def take(self, frame: Frame) -> float:
        """Handle a frame and release its memory. Return the CPU time [s] spent on this thread."""
        worked_s, is_whole = 0.0, False
        following: Frame | None = frame
        del frame
        while following is not None:
            if len(following) > LARGE_FRAME_BYTES:
                work = partial(self.session.prepare, following, is_whole=is_whole)
                prepared = await self._desk.do(work, len(following))
                del work
                begun_s = time.thread_time()
            else:
                begun_s = time.thread_time()
                prepared = self.session.prepare(following, is_whole=is_whole)
            following, is_whole = self.session.perform(prepared), True
            worked_s += time.thread_time() - begun_s
            del prepared
        return worked_s

    async def next_frame(self) -> tuple[Frame | None, float | None]:
        """Return the next frame to send. If there is none, return None and the seconds until one is due, if known."""
        outbox = self.session.outbox
        found, delay_s = outbox.pick()
        if isinstance(found, Parcel):
            return outbox.begun(await self._desk.encode(found), found.fragment_size), delay_s
        return found, delay_s

    def close(self) -> None:
        """Leave the graph."""
        self.session.close()


def _timed(work: Callable[[], T]) -> tuple[T, float]:
    begun_s = time.thread_time()  # CPU time of this thread only, not of others sharing the core
    return work(), time.thread_time() - begun_s
