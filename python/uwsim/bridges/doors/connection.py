"""HeardConnection: a client's WebSocket that limits the client's load on the server and tracks its liveness."""

from __future__ import annotations

import asyncio
from typing import Any, ClassVar

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode, Frame, Opcode

from uwsim.bridges.doors.places import HALF_OPEN_MAX, HALF_OPEN_S, HalfOpen, Places

READ_BYTES = 1 << 13  # bytes per read; enough for a thousand frames without content
CONTINUATIONS = 1000  # frames per message
UNREAD_PONGS_BYTES = 1 << 20
SWEEP_LATER_S = 0.01  # so that the sweep finds the connection too old
GOING_S = 2.0  # time limit for the closing handshake
REASON_BYTES = 123  # RFC 6455, section 5.5


class HeardConnection(ServerConnection):
    """A connection that tracks the time since anything, including replies to pings, was received.

    silent_s: seconds without received data, incremented by the server, excluding time during which the event loop was
    blocked. half_open: the server's connections that have not yet sent a request. places: those whose request was
    granted; a client speaks by messages, and then also by its replies to pings. most: maximum number of connections to
    the server, including half-open ones; further connections are aborted.
    """

    silent_s = 0.0
    most: ClassVar[int]
    made: ClassVar[set[HeardConnection]]
    half_open: ClassVar[HalfOpen[HeardConnection]]
    places: ClassVar[Places[HeardConnection]]

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._continuations = 0
        self._unread_pongs_bytes = 0
        self._has_spoken = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Limit the read size and the number of connections."""
        super().connection_made(transport)
        if hasattr(transport, "max_size"):
            transport.max_size = READ_BYTES
        self.made.add(self)
        self.half_open.add(self)  # may abort the one that came first
        if len(self.made) > self.most:
            self.transport.abort()
        self.loop.call_later(HALF_OPEN_S + SWEEP_LATER_S, self.half_open.sweep)

    def connection_lost(self, exc: Exception | None) -> None:
        """Make room for a new connection."""
        self.half_open.discard(self)
        self.made.discard(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Record that the client is alive. A client that keeps pinging without reading the replies is disconnected."""
        self.silent_s = 0.0
        before = self.transport.get_write_buffer_size()
        super().data_received(data)
        if self._has_spoken and self in self.places:
            self.places.renew(self)
        after = self.transport.get_write_buffer_size()
        self._unread_pongs_bytes = 0 if after == 0 else self._unread_pongs_bytes + max(0, after - before)
        if self._unread_pongs_bytes > UNREAD_PONGS_BYTES:
            self.transport.abort()

    def process_event(self, event: Any) -> None:
        """Process a frame. Messages in too many frames are refused, because each frame has a cost beyond its bytes."""
        if isinstance(event, Frame) and event.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
            self._has_spoken = True
            self._continuations = self._continuations + 1 if event.opcode is Opcode.CONT else 0
            if self._continuations > CONTINUATIONS:
                self.protocol.fail(CloseCode.POLICY_VIOLATION, f"a message in more than {CONTINUATIONS} frames")
                return
        super().process_event(event)

    def abort(self) -> None:
        """Close at once, and make room for a new connection."""
        self.made.discard(self)
        self.transport.abort()

    def make_room(self) -> None:
        """Close at once, with the reason as far as it can be sent."""
        self.protocol.fail(CloseCode.TRY_AGAIN_LATER, "too many clients: one that was silent is disconnected")
        self.send_data()
        self.abort()

    async def dismiss(self, reason: str) -> None:
        """Close with a reason, even in the middle of a message, without waiting long for a client that may not read."""
        reason = reason.encode()[:REASON_BYTES].decode(errors="ignore")
        try:
            async with asyncio.timeout(GOING_S), self.send_context():
                self.protocol.fail(CloseCode.POLICY_VIOLATION, reason)
        except (TimeoutError, ConnectionClosed):
            pass
        finally:
            self.transport.abort()


def connections_of_one_server(places: int) -> type[HeardConnection]:
    """Return a connection class that allows so many clients, and HALF_OPEN_MAX half-open connections."""
    half_open: HalfOpen[HeardConnection] = HalfOpen(lambda connection: connection.abort())
    of_clients: Places[HeardConnection] = Places(lambda connection: connection.make_room(), places)
    own = {"most": places + HALF_OPEN_MAX, "made": set(), "half_open": half_open, "places": of_clients}
    return type("BoundedConnection", (HeardConnection,), own)
