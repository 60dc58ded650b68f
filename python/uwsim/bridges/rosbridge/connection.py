"""One client's WebSocket: frames in at a bounded rate, the outbox out.

The network's thread serves all clients, so nothing may hold it for long. Large frames are read, and large messages
encoded, on a thread beside it, one after the other and in slices.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import Any, TypeVar

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode, Frame, Opcode

from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.outbox import Parcel
from uwsim.bridges.rosbridge.session import Session

AT_ONCE = 16  # frames after which others get their turn
LARGE_FRAME_BYTES = 1 << 13
PAUSE_S = 5e-5  # in which the other threads take their turn
READ_BYTES = 1 << 13  # at once: of frames without content that is a thousand
CONTINUATIONS = 1000  # frames of one message
UNREAD_PONGS_BYTES = 1 << 20
S_PER_BYTE = 5e-8  # of work on a large frame, charged before it is done; what it took is settled afterwards
GOING_S = 2.0  # for a closing handshake
REASON_BYTES = 123  # RFC 6455, section 5.5

T = TypeVar("T")


class HeardConnection(ServerConnection):
    """A connection that knows for how long nothing has come through it, answers to pings included.

    silent_s: somebody must count it up. Time in which the loop stood still is not silence.
    """

    silent_s = 0.0

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._continuations = 0
        self._unread_pongs_bytes = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Read little at once."""
        super().connection_made(transport)
        if hasattr(transport, "max_size"):
            transport.max_size = READ_BYTES

    def data_received(self, data: bytes) -> None:
        """Take note that the other side lives. One that pings on and does not read the answers is cut off."""
        self.silent_s = 0.0
        before = self.transport.get_write_buffer_size()
        super().data_received(data)
        after = self.transport.get_write_buffer_size()
        self._unread_pongs_bytes = 0 if after == 0 else self._unread_pongs_bytes + max(0, after - before)
        if self._unread_pongs_bytes > UNREAD_PONGS_BYTES:
            self.transport.abort()

    def process_event(self, event: Any) -> None:
        """Take a frame. A message in very many costs more than its bytes: it is refused."""
        if isinstance(event, Frame) and event.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
            self._continuations = self._continuations + 1 if event.opcode is Opcode.CONT else 0
            if self._continuations > CONTINUATIONS:
                self.protocol.fail(CloseCode.POLICY_VIOLATION, f"a message in more than {CONTINUATIONS} frames")
                return
        super().process_event(event)

    async def dismiss(self, reason: str) -> None:
        """Close with a reason; the other side may not read it, and is not waited for."""
        try:
            async with asyncio.timeout(GOING_S):
                await self.close(CloseCode.POLICY_VIOLATION, reason.encode()[:REASON_BYTES].decode(errors="ignore"))
        except TimeoutError:
            pass
        finally:
            self.transport.abort()


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


class Desk:
    """Where large pieces of work are done: on one thread, within the share of time that all clients have together."""

    def __init__(self, limits: Limits, pool: Executor) -> None:
        self._share = Allowance(limits.work_share)
        self._pool = pool

    def charge(self, worked_s: float) -> float:
        """Count work; return the seconds to wait before the next."""
        return self._share.delay_after(worked_s)

    async def do(self, work: Callable[[], T], size: int) -> T:
        """Wait for the time that work on so many bytes will take, then do it beside the network's thread."""
        expected_s = S_PER_BYTE * size
        await asyncio.sleep(self._share.delay_after(expected_s))
        result, worked_s = await asyncio.get_running_loop().run_in_executor(self._pool, _timed, work)
        self._share.delay_after(worked_s - expected_s)
        return result

    async def encode(self, parcel: Parcel) -> str | bytes:
        """Return the frame of a message that is due. What the simulator publishes is not charged to the clients."""
        if not parcel.sample.is_large:
            return parcel.encode()
        return await asyncio.get_running_loop().run_in_executor(self._pool, parcel.encode)


def _timed(work: Callable[[], T]) -> tuple[T, float]:
    begun_s = time.thread_time()  # of this thread: not while others have the core
    return work(), time.thread_time() - begun_s


def _pause() -> None:
    time.sleep(PAUSE_S)


async def converse(
    connection: ServerConnection, session: Session, wakes: asyncio.Event, limits: Limits, desk: Desk
) -> None:
    """Carry frames both ways until either side ends it. desk: of all clients together."""
    writer = asyncio.create_task(_write(connection, session, wakes, desk))
    try:
        await _read(connection, session, limits, desk)
    except ConnectionClosed:
        pass
    finally:
        writer.cancel()
        await asyncio.gather(writer, return_exceptions=True)


async def _read(connection: ServerConnection, session: Session, limits: Limits, desk: Desk) -> None:
    messages, data = Allowance(limits.messages_per_s), Allowance(limits.bytes_per_s)
    count = 0
    while True:
        size, worked_s = await _take(await connection.recv(), session, desk)
        delay_s = max(messages.delay_after(1), data.delay_after(size), desk.charge(worked_s))
        count += 1
        if delay_s or count % AT_ONCE == 0:
            await asyncio.sleep(delay_s)


async def _take(frame: str | bytes, session: Session, desk: Desk) -> tuple[int, float]:
    """Do what a frame asks for; return its size and the seconds of work on this thread. No longer is it kept."""
    size, worked_s, is_whole = len(frame), 0.0, False
    following: str | bytes | None = frame
    del frame
    while following is not None:
        if len(following) > LARGE_FRAME_BYTES:
            work = partial(session.prepare, following, _pause, is_whole=is_whole)
            prepared = await desk.do(work, len(following))
            del work
            begun_s = time.thread_time()
        else:
            begun_s = time.thread_time()
            prepared = session.prepare(following, is_whole=is_whole)
        following, is_whole = session.perform(prepared), True
        worked_s += time.thread_time() - begun_s
        del prepared
    return size, worked_s


async def _write(connection: ServerConnection, session: Session, wakes: asyncio.Event, desk: Desk) -> None:
    loop = asyncio.get_running_loop()
    count = 0
    while True:
        found, delay_s = session.outbox.pick()
        if found is None:
            wakes.clear()
            timer = None if delay_s is None else loop.call_later(delay_s, wakes.set)
            await wakes.wait()
            if timer is not None:
                timer.cancel()
            continue
        if isinstance(found, Parcel):
            found = await desk.encode(found)
        await connection.send(found)
        del found  # which may be large, and the next one far away
        count += 1
        if count % AT_ONCE == 0:
            await asyncio.sleep(0)
