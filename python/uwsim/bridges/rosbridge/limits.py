"""Limits on client requests. A client that exceeds a limit receives an error, has to wait, or is disconnected."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Limits:
    """Limits per client and for all clients together. Raises ValueError unless all are positive."""

    connections: int = 256
    """Clients at a time; of more, one that was silent is disconnected (uwsim.bridges.doors.places)."""
    frame_bytes: int = 2 << 20
    """Size of a frame from a client, and of a message assembled from fragments."""
    nesting: int = 32
    """Depth of objects and lists in a client's JSON or CBOR."""
    objects: int = 20_000
    """Objects and lists in a frame, and messages within its message; in CBOR, five times as many items are allowed."""
    strings: int = 200_000
    """Strings in a frame."""
    cost_factor: int = 20
    """Memory that a frame may take while it is being handled, in multiples of its size; see cost_of."""
    cost_bytes: int = 1 << 20
    """Memory that any frame may take: small frames expand more than large ones."""
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
    """Data queued and stored for a client [bytes]: messages to be sent, latched messages, fragments, open calls."""
    mailbox_bytes: int = 16 << 20
    """Size of one subscription's queue; beyond it, as beyond the queue's length, the oldest messages are dropped."""
    total_bytes: int = 512 << 20
    """Data queued and stored for all clients; beyond it, the client with the most data is disconnected."""
    messages_per_s: float = 2000.0
    """Messages from a client. Beyond this rate, the client is read more slowly.

    A burst of one second's worth is allowed.
    """
    bytes_per_s: float = 16e6
    """Bytes from a client, limited in the same way."""

    work_share: float = 0.3
    """The fraction of a core for all clients' frames: Python runs one thread at a time, and steps need time, too."""

    def cost_of(self, size: int) -> int:
        """Return the memory that a frame of a given size may take."""
        return max(self.cost_bytes, self.cost_factor * size)

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0:
                raise ValueError(f"limits.{field.name} = {getattr(self, field.name)}: must be positive")
