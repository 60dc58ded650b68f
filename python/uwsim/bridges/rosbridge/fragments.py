"""Messages that a client sends in pieces (op "fragment"), put together again."""

from __future__ import annotations

from typing import Any

from uwsim.bridges.rosbridge.limits import Limits


class Fragments:
    """The messages that one client has begun. They are few and small: see Limits."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._begun: dict[str, list[str | None]] = {}

    def add(self, operation: dict[str, Any]) -> str | None:
        """Take a fragment; return the whole message with the last one. Raises ValueError."""
        identity, data = operation.get("id"), operation.get("data")
        number, total = operation.get("num"), operation.get("total")
        if not isinstance(identity, str | int) or not isinstance(data, str):
            raise ValueError("fragment: id and data must be strings")
        if not (type(total) is int and 1 <= total <= self._limits.fragments):
            raise ValueError(f"fragment.total = {total!r:.40}: must be in [1, {self._limits.fragments}]")
        if not (type(number) is int and 0 <= number < total):
            raise ValueError(f"fragment.num = {number!r:.40}: must be in [0, {total - 1}]")
        parts = self._begun.pop(str(identity), None)
        if parts is None or len(parts) != total:
            parts = [None] * total
        parts[number] = data
        self._begun[str(identity)] = parts  # last: the longest untouched one comes first
        if sum(len(part) for part in parts if part is not None) > self._limits.frame_bytes:
            del self._begun[str(identity)]
            raise ValueError(f"fragments: more than {self._limits.frame_bytes} bytes in all")
        if len(self._begun) > self._limits.fragmented_messages:
            del self._begun[next(iter(self._begun))]
        if any(part is None for part in parts):
            return None
        del self._begun[str(identity)]
        return "".join(part for part in parts if part is not None)
