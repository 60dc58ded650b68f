"""Base64 in chunks, because a single call on megabytes of data would hold the GIL and block all other threads."""

from __future__ import annotations

import binascii

PIECE_BYTES = 3 << 16
PIECE_CHARACTERS = 4 << 16


def to_base64(data: bytes | memoryview) -> str:
    """Encode data as base64."""
    pieces = (data[at : at + PIECE_BYTES] for at in range(0, len(data), PIECE_BYTES))
    return "".join(binascii.b2a_base64(piece, newline=False).decode() for piece in pieces)


def from_base64(text: str) -> bytes:
    """Decode base64. Raises ValueError for characters outside the alphabet and for incorrect padding."""
    last = max(0, len(text) - 1) // PIECE_CHARACTERS * PIECE_CHARACTERS
    if "=" in text[:last]:
        raise ValueError("padding before the end")
    starts = range(0, len(text), PIECE_CHARACTERS)
    return b"".join(binascii.a2b_base64(text[at : at + PIECE_CHARACTERS], strict_mode=True) for at in starts)
