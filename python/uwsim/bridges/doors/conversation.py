"""Handles the traffic on a client's WebSocket: reads frames at a limited rate, and sends queued frames."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from contextlib import suppress
from typing import Any, NamedTuple, Protocol

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

Frame = str | bytes
"""A WebSocket frame: str for text, bytes for binary."""
AT_ONCE, AT_ONCE_S = 16, 0.002  # frames, or CPU time, after which other clients get a turn
UNDER_WAY_S, PING_S = 0.25, 0.1
"""For so long a client may take to read what is under way to it, and how often that is measured, at least."""
FIRST_UNDER_WAY, MOST_UNDER_WAY = 8, 1 << 12
"""Messages under way at first, and at most."""
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


class Pace:
    """How many messages may be under way to a client, so that what it reads is new.

    The system holds megabytes that a client has not read yet: seconds or minutes of messages for a slow one, whatever
    the queues. A client answers a ping when it has read what was sent before, so that the time of the answer measures
    how fast it reads: as many messages may be under way as it reads within UNDER_WAY_S, and one at least.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._window = FIRST_UNDER_WAY
        self._unread = self._asked_about = 0
        self._asked_s = -math.inf

    @property
    def is_asked(self) -> bool:
        """True while a ping is unanswered."""
        return self._asked_about > 0

    @property
    def is_due(self) -> bool:
        """True if a ping must be sent."""
        is_late = self._clock() - self._asked_s > PING_S
        return not self.is_asked and self._unread > 0 and (2 * self._unread >= self._window or is_late)

    @property
    def is_full(self) -> bool:
        """True if nothing more may be sent until the ping is answered."""
        is_late = self.is_asked and self._clock() - self._asked_s > UNDER_WAY_S
        return self._unread >= self._window or is_late

    def sent(self) -> None:
        """Count a message."""
        self._unread += 1

    def asked(self) -> None:
        """Note that a ping was sent after the messages so far."""
        self._asked_about, self._asked_s = self._unread, self._clock()

    def answered(self) -> None:
        """Note the answer to the ping."""
        fits = UNDER_WAY_S * self._asked_about / max(self._clock() - self._asked_s, 1e-6)
        self._window = int(min(max(fits, 1), 2 * self._window, MOST_UNDER_WAY))
        self._unread -= self._asked_about
        self._asked_about = 0


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
    """Transfer frames in both directions until either side ends. share: limits the total CPU time for all clients.

    Raises what either direction raised: a client that is no longer sent anything would wait for it in silence.
    """
    share.clients += 1
    try:
        with suppress(ConnectionClosed):
            await first_of(_read(connection, session, rates, share), _write(connection, session, wakes))
    finally:
        share.clients -= 1


async def first_of(*ways: Coroutine[Any, Any, None]) -> None:
    """Run all until one ends, and raise what one raised: of several the first, but a closed connection last."""
    tasks = [asyncio.create_task(way) for way in ways]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        ended = await asyncio.gather(*tasks, return_exceptions=True)
    errors = [each for each in ended if isinstance(each, Exception)]
    errors.sort(key=lambda error: isinstance(error, ConnectionClosed))
    del tasks, task, ended  # an error's traceback has this frame: what it holds would be freed by a collection only
    if errors:
        raise errors.pop(0)


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
    count, pace = 0, Pace()
    pong: Awaitable[float] | None = None
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
        pace.sent()
        while True:
            if pace.is_due:
                pong = await connection.ping()
                pace.asked()
                asyncio.ensure_future(pong).add_done_callback(lambda _: pace.answered())
            if pong is None or not pace.is_full:
                break
            await pong
            await asyncio.sleep(0)  # in which the answer is noted
        count += 1
        if count % AT_ONCE == 0:
            await asyncio.sleep(0)


def _pieces(message: Frame) -> Iterator[Frame]:
    return (message[at : at + PIECE] for at in range(0, len(message), PIECE))
