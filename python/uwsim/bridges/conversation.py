"""Handles the traffic on a client's WebSocket: reads frames at a limited rate, and sends queued frames."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from typing import Any, NamedTuple, Protocol

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

Frame = str | bytes
"""A WebSocket frame: str for text, bytes for binary."""
AT_ONCE, AT_ONCE_S = 16, 0.002  # frames, or CPU time, after which other clients get a turn
PIECE = 1 << 18  # characters or bytes; a larger message is sent in several frames, so that no write takes long


class Allowance:
    """A token bucket that limits a client to `rate` per second, with bursts of one second's worth."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._left = rate
        self._seen_s = time.monotonic()

    def delay_after(self, amount: float) -> float:
        """Consume an amount; return the number of seconds to wait before the next."""
        now_s = time.monotonic()
        self._left = min(self._rate, self._left + (now_s - self._seen_s) * self._rate) - amount
        self._seen_s = now_s
        return max(0.0, -self._left / self._rate)


class Share(Allowance):
    """Limits the CPU time that the frames of all clients take together to a fraction of a core.

    A client that has taken less than an equal part of it is not delayed, whatever the others do. clients: their number.
    """

    def __init__(self, fraction: float) -> None:
        super().__init__(fraction)
        self.fraction = fraction
        self.clients = 0


class Rates(NamedTuple):
    """Limits on the frames and bytes that a client may send per second. Beyond them, its data is read more slowly."""

    frames: float
    bytes: float


class Session(Protocol):
    """The server's side of a conversation with one client, without a transport."""

    async def take(self, frame: Frame) -> float:
        """Handle a frame; return the CPU time [s] spent on this thread."""

    async def next_frame(self) -> tuple[Frame | None, float | None]:
        """Return the next frame to send. If there is none, return None and the seconds until one is due, if known."""

    def close(self) -> None:
        """End the session; nothing more is sent."""


async def converse(
    connection: ServerConnection, session: Session, wakes: asyncio.Event, rates: Rates, share: Share
) -> None:
    """Transfer frames in both directions until either side ends. share: limits the total CPU time for all clients."""
    share.clients += 1
    writer = asyncio.create_task(_write(connection, session, wakes))
    try:
        await _read(connection, session, rates, share)
    except ConnectionClosed:
        pass
    finally:
        share.clients -= 1
        writer.cancel()
        await asyncio.gather(writer, return_exceptions=True)


async def _read(connection: ServerConnection, session: Session, rates: Rates, share: Share) -> None:
    frames, data, own = Allowance(rates.frames), Allowance(rates.bytes), Allowance(share.fraction)
    count, since_s = 0, 0.0
    while True:
        frame: Any = await connection.recv()
        size = len(frame)
        taking = session.take(frame)
        del frame  # freed as soon as the session no longer needs it
        worked_s = await taking
        work_delay_s = min(share.delay_after(worked_s), own.delay_after(worked_s * share.clients))
        delay_s = max(frames.delay_after(1), data.delay_after(size), work_delay_s)
        count, since_s = count + 1, since_s + worked_s
        if delay_s or count % AT_ONCE == 0 or since_s > AT_ONCE_S:
            since_s = 0.0
            await asyncio.sleep(delay_s)


async def _write(connection: ServerConnection, session: Session, wakes: asyncio.Event) -> None:
    loop = asyncio.get_running_loop()
    count = 0
    while True:
        wakes.clear()  # before checking, since another thread may add a frame between the two
        frame, delay_s = await session.next_frame()
        if frame is None:
            timer = None if delay_s is None else loop.call_later(delay_s, wakes.set)
            await wakes.wait()
            if timer is not None:
                timer.cancel()
            continue
        await connection.send(frame if len(frame) <= PIECE else _pieces(frame))
        del frame  # it may be large, and the next frame may come much later
        count += 1
        if count % AT_ONCE == 0:
            await asyncio.sleep(0)


def _pieces(message: Frame) -> Iterator[Frame]:
    return (message[at : at + PIECE] for at in range(0, len(message), PIECE))
