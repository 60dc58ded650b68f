"""One client's WebSocket: frames in at a bounded rate, the outbox out."""

from __future__ import annotations

import asyncio
import time

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.session import Session

AT_ONCE = 16  # frames after which others get their turn


class HeardConnection(ServerConnection):
    """A connection that knows for how long nothing has come through it, answers to pings included.

    silent_s: somebody must count it up. Time in which the loop stood still is not silence.
    """

    silent_s = 0.0

    def data_received(self, data: bytes) -> None:
        """Take note that the other side lives."""
        self.silent_s = 0.0
        super().data_received(data)


class Allowance:
    """How much a client may send: a second's worth at once, then `rate` a second (a token bucket)."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._left = rate
        self._seen_s = time.monotonic()

    def delay_after(self, amount: float) -> float:
        """Take an amount; return the seconds to wait before the next one."""
        now_s = time.monotonic()
        self._left = min(self._rate, self._left + (now_s - self._seen_s) * self._rate) - amount
        self._seen_s = now_s
        return max(0.0, -self._left / self._rate)


async def converse(
    connection: ServerConnection, session: Session, wakes: asyncio.Event, limits: Limits, work_s: Allowance
) -> None:
    """Carry frames both ways until either side ends it. work_s: of all clients together."""
    writer = asyncio.create_task(_write(connection, session, wakes))
    try:
        await _read(connection, session, limits, work_s)
    except ConnectionClosed:
        pass
    finally:
        writer.cancel()
        await asyncio.gather(writer, return_exceptions=True)


async def _read(connection: ServerConnection, session: Session, limits: Limits, work_s: Allowance) -> None:
    messages, data = Allowance(limits.messages_per_s), Allowance(limits.bytes_per_s)
    count = 0
    async for frame in connection:
        begun_s = time.thread_time()  # of this core: not while others have it
        session.receive(frame)
        worked_s = time.thread_time() - begun_s
        delay_s = max(messages.delay_after(1), data.delay_after(len(frame)), work_s.delay_after(worked_s))
        count += 1
        if delay_s or count % AT_ONCE == 0:
            await asyncio.sleep(delay_s)


async def _write(connection: ServerConnection, session: Session, wakes: asyncio.Event) -> None:
    loop = asyncio.get_running_loop()
    count = 0
    while True:
        frame, delay_s = session.outbox.take()
        if frame is None:
            wakes.clear()
            timer = None if delay_s is None else loop.call_later(delay_s, wakes.set)
            await wakes.wait()
            if timer is not None:
                timer.cancel()
            continue
        await connection.send(frame)
        count += 1
        if count % AT_ONCE == 0:
            await asyncio.sleep(0)
