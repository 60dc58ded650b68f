"""HeardConnection: a client's WebSocket that limits what the client can make it do, and tracks whether it is alive."""

from __future__ import annotations

import asyncio
from typing import Any, ClassVar

from websockets.asyncio.server import ServerConnection
from websockets.frames import CloseCode, Frame, Opcode

READ_BYTES = 1 << 13  # read at once; that is a thousand frames without content
CONTINUATIONS = 1000  # frames of one message
UNREAD_PONGS_BYTES = 1 << 20
HEAD_S = 5.0  # time limit for a request's head, and before it for encryption
GOING_S = 2.0  # wait for a closing handshake
REASON_BYTES = 123  # RFC 6455, section 5.5


class HeardConnection(ServerConnection):
    """A connection that records how long nothing has been received, including answers to pings.

    silent_s: incremented by its server. Time during which the event loop was blocked does not count. most: limit on
    the connections of a server, including half-open ones; a further one is cut off.
    """

    silent_s = 0.0
    most: ClassVar[int]
    made: ClassVar[set[HeardConnection]]

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._continuations = 0
        self._unread_pongs_bytes = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Limit how much is read at once."""
        super().connection_made(transport)
        if hasattr(transport, "max_size"):
            transport.max_size = READ_BYTES
        self.made.add(self)
        if len(self.made) > self.most:
            self.transport.abort()
        self.loop.call_later(HEAD_S, self._require_head)

    def connection_lost(self, exc: Exception | None) -> None:
        """Leave room for another."""
        self.made.discard(self)
        super().connection_lost(exc)

    def _require_head(self) -> None:
        if self.request is None:
            self.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Note that the other side is alive. One that keeps pinging without reading the answers is cut off."""
        self.silent_s = 0.0
        before = self.transport.get_write_buffer_size()
        super().data_received(data)
        after = self.transport.get_write_buffer_size()
        self._unread_pongs_bytes = 0 if after == 0 else self._unread_pongs_bytes + max(0, after - before)
        if self._unread_pongs_bytes > UNREAD_PONGS_BYTES:
            self.transport.abort()

    def process_event(self, event: Any) -> None:
        """Process a frame. A message in very many frames is refused, because it costs more than its bytes."""
        if isinstance(event, Frame) and event.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
            self._continuations = self._continuations + 1 if event.opcode is Opcode.CONT else 0
            if self._continuations > CONTINUATIONS:
                self.protocol.fail(CloseCode.POLICY_VIOLATION, f"a message in more than {CONTINUATIONS} frames")
                return
        super().process_event(event)

    async def dismiss(self, reason: str) -> None:
        """Close with a reason, without waiting for the other side, which may not read it."""
        try:
            async with asyncio.timeout(GOING_S):
                await self.close(CloseCode.POLICY_VIOLATION, reason.encode()[:REASON_BYTES].decode(errors="ignore"))
        except TimeoutError:
            pass
        finally:
            self.transport.abort()


def connections_of_one_server(most: int) -> type[HeardConnection]:
    """Return a class of connections of which there are at most so many at a time."""
    return type("BoundedConnection", (HeardConnection,), {"most": most, "made": set()})
