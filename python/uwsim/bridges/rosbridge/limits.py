"""Limits of a client's requests: beyond them it gets an error, waits, or is disconnected."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Limits:
    """Bounds for each client, and for all. Raises ValueError unless all are positive."""

    connections: int = 256
    """Clients at a time; further ones are refused with HTTP 503."""
    frame_bytes: int = 2 << 20
    """Size of a frame from a client, and of a message assembled from fragments."""
    nesting: int = 32
    """Depth of objects and lists in a client's JSON or CBOR."""
    objects: int = 20_000
    """Objects and lists in a frame, and messages within its message; for CBOR five times as many items."""
    strings: int = 200_000
    """Strings in a frame."""
    cost_factor: int = 20
    """Memory that a frame may take while it is being handled, in multiples of its size; see cost_of."""
    cost_bytes: int = 1 << 20
    """Memory that any frame may take: small frames expand more than large ones."""
    fragmented_messages: int = 4
    """Unfinished fragmented messages of a client; a further one discards the oldest."""
    fragments: int = 1000
    """Fragments of one message."""
    names: int = 1000
    """Topics and services that a client may advertise and subscribe to."""
    all_names: int = 5000
    """Topics and services of all clients and the simulator together."""
    queue_length: int = 1000
    """The longest queue that a subscription may request; for images, clouds and maps 8."""
    replies: int = 1000
    """Queued answers: a client that keeps asking without reading is disconnected."""
    open_calls: int = 1000
    """Unanswered calls of a client's own services, and unanswered calls made by a client."""
    identity: int = 256
    """Length of an id."""
    ids: int = 100
    """Number of ids of one subscription."""
    client_bytes: int = 64 << 20
    """Data queued and stored for a client: messages to be sent, latched ones, fragments, open calls."""
    mailbox_bytes: int = 16 << 20
    """Size of one subscription's queue: beyond it the oldest messages are dropped, as beyond the queue's length."""
    total_bytes: int = 512 << 20
    """Data queued and stored for all clients: beyond it the one with the most is disconnected."""
    messages_per_s: float = 2000.0
    """Rate from a client; one that sends more is read more slowly. The messages of a second may arrive at once."""
    bytes_per_s: float = 16e6
    """From a client, in the same way."""

    work_share: float = 0.3
    """Share of a core for all clients' frames together: Python runs one thread at a time, and steps need their turn."""

    def cost_of(self, size: int) -> int:
        """Return the memory that a frame of a given size may take."""
        return max(self.cost_bytes, self.cost_factor * size)

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0:
                raise ValueError(f"limits.{field.name} = {getattr(self, field.name)}: must be positive")
