"""The hosts in addresses of peers."""

from __future__ import annotations

import re

_HOST = re.compile(r"[\w-]{1,63}(\.[\w-]{1,63})*")
_LENGTH_MAX = 253  # characters (RFC 1035)


def checked_host(host: str, given: str) -> str:
    """Return a host's name or IPv4 address. given: the option and its value, for the message. Raises ValueError."""
    if len(host) > _LENGTH_MAX or not _HOST.fullmatch(host):
        raise ValueError(f"{given}: the host must be a name or an IPv4 address")
    return host
