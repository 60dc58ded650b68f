"""Limits on client requests. A client that exceeds a limit receives an error, has to wait, or is disconnected."""

from __future__ import annotations

from dataclasses import dataclass, fields

DECODED = 48
"""Bytes of a frame's decoded values, and of its message, for each of its bytes: `"a":0,` is six, and takes 200."""


@dataclass(frozen=True)
class Limits:
    """Limits per client and for all clients together. Raises ValueError unless all are positive."""

    connections: int = 256
    """Clients at a time; of more, one that was silent is disconnected (uwsim.bridges.doors.places)."""
    frame_bytes: int = 2 << 20
    """Size of a frame from a client, and of a message assembled from fragments: see most_bytes."""
    nesting: int = 32
    """Depth of objects and lists in a client's JSON or CBOR."""
    objects: int = 20_000
    """Brackets in a frame of JSON, and messages within its message; in CBOR, five times as many items are allowed."""
    fragmented_messages: int = 4
    """Unfinished fragmented messages of a client; one more discards the oldest."""
    fragments: int = 1000
    """Fragments of one message."""
    names: int = 1000
    """Topics and services that a client may advertise and subscribe to."""
    all_names: int = 5000
    """Topics and services of all clients and the simulator together."""
    queue_length: int = 1000
    """The longest queue that a subscription may request; for images, point clouds and maps, it is 8."""
    replies: int = 1000
    """Queued answers; a client that keeps sending requests without reading the answers is disconnected."""
    open_calls: int = 1000
    """Unanswered calls by a client, and unanswered calls of the services that it offers."""
    identity: int = 256
    """Length of an id."""
    ids: int = 100
    """Number of ids per subscription."""
    client_bytes: int = 64 << 20
    """Data of a client [bytes]: half for what waits to be sent, of which the oldest messages give way to newer ones.

    The other half is for what is kept otherwise: latched messages, fragments, open calls.
    """
    total_bytes: int = 512 << 20
    """The same for all clients, of whom each has an equal share."""
    messages_per_s: float = 2000.0
    """Messages from a client. Beyond this rate, the client is read more slowly.

    A burst of one second's worth is allowed.
    """
    bytes_per_s: float = 16e6
    """Bytes from a client, limited in the same way."""

    work_share: float = 0.3
    """The fraction of a core for all clients' frames: Python runs one thread at a time, and steps need time, too."""

    def room(self, clients: int) -> float:
        """Return the number of bytes that may wait for one of so many clients, and as many may be kept otherwise."""
        return min(self.client_bytes, self.total_bytes / clients) / 2

    @property
    def most_bytes(self) -> int:
        """The memory that all clients together can make the server take.

        What is queued and stored, the frames that arrive, two of each client, and the one that is decoded: large ones
        are decoded one at a time, and their values take up to DECODED times their size.
        """
        return self.total_bytes + (2 * self.connections + DECODED) * self.frame_bytes

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0:
                raise ValueError(f"limits.{field.name} = {getattr(self, field.name)}: must be positive")
