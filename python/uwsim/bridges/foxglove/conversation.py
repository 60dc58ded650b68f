"""A client's WebSocket: frames in at a bounded rate, the outbox out."""

from __future__ import annotations

import asyncio
import time

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from uwsim.bridges.foxglove.session import Session
from uwsim.bridges.rosbridge.connection import Allowance

FRAMES_PER_S = 1000.0  # from a client; one that sends more is read more slowly
BYTES_PER_S = 4e6
AT_ONCE = 16  # frames after which others get their turn


async def converse(connection: ServerConnection, session: Session, wakes: asyncio.Event, work_s: Allowance) -> None:
    """Carry frames both ways until either side ends it. work_s: of all clients together."""
    writer = asyncio.create_task(_write(connection, session, wakes))
    try:
        await _read(connection, session, work_s)
    except ConnectionClosed:
        pass
    finally:
        writer.cancel()
        await asyncio.gather(writer, return_exceptions=True)


async def _read(connection: ServerConnection, session: Session, work_s: Allowance) -> None:
    frames, data = Allowance(FRAMES_PER_S), Allowance(BYTES_PER_S)
    count = 0
    async for frame in connection:
        begun_s = time.thread_time()  # of this core: not while others have it
        session.receive(frame)
        worked_s = time.thread_time() - begun_s
        delay_s = max(frames.delay_after(1), data.delay_after(len(frame)), work_s.delay_after(worked_s))
        count += 1
        if delay_s or count % AT_ONCE == 0:
            await asyncio.sleep(delay_s)


async def _write(connection: ServerConnection, session: Session, wakes: asyncio.Event) -> None:
    count = 0
    while True:
        wakes.clear()  # before looking: another thread may put something meanwhile
        frame = session.outbox.take()
        if frame is None:
            await wakes.wait()
            continue
        await connection.send(frame)
        count += 1
        if count % AT_ONCE == 0:
            await asyncio.sleep(0)
