"""Endpoint: where a protocol is spoken, as an option states it: [OWNER=][KIND:][HOST:]PORT."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

ROSBRIDGE_PORT = 9090
"""The port of rosbridge_server, and so of our servers."""
OWN_HOST = "127.0.0.1"
_HOST = re.compile(r"[\w-]{1,63}(\.[\w-]{1,63})*")
_LENGTH_MAX = 253  # characters (RFC 1035)


class Endpoint(NamedTuple):
    """A host and a port. kind: such as "udp". owner: the vehicle or instrument that it is for; "" for the first."""

    host: str
    port: int
    kind: str = ""
    owner: str = ""

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}".lstrip(":")

    @property
    def is_local(self) -> bool:
        """True for this machine."""
        return self.host == "localhost" or self.host.startswith("127.")


@dataclass(frozen=True)
class EndpointForm:
    """The form of an option's endpoints.

    form: as the error states it; with "=", an owner may be named. ports: the kinds with their usual port, or None if
    there is none; "" is the kind of an endpoint without one. sends: the kinds whose port cannot be 0, which lets a
    listener choose. needs_host: whether the host must be named. bare: the kinds that have neither host nor port.
    """

    option: str
    form: str
    ports: Mapping[str, int | None]
    sends: tuple[str, ...] = ()
    needs_host: bool = False
    bare: tuple[str, ...] = ()

    def parse(self, text: str) -> Endpoint:
        """Return the endpoint that a text states. Raises ValueError."""
        owner, equals, where = text.rpartition("=")
        kind, *rest = where.split(":")
        if not kind or kind not in self.ports:
            kind, rest = "", [kind, *rest]
        is_right = len(rest) <= 2 and not (rest and kind in self.bare) and (bool(rest) or not self.needs_host)
        has_port = len(rest) == 2 or (len(rest) == 1 and rest[0].isdecimal() and not self.needs_host)
        port = rest.pop() if has_port else str(self.ports.get(kind))
        host = rest.pop() if rest else OWN_HOST
        lowest = 1 if kind in self.sends else 0
        if (
            not is_right
            or kind not in self.ports
            or (equals and not (owner and "=" in self.form))
            or not (re.fullmatch(r"\d{1,5}", port) and lowest <= int(port) <= 65535)
            or not (len(host) <= _LENGTH_MAX and _HOST.fullmatch(host))
        ):
            rule = f"the port in [{lowest}, 65535], the host a name or an IPv4 address"
            raise ValueError(f"{self.option} = '{text[:80]}': must be {self.form}, {rule}")
        return Endpoint(host, int(port), kind, owner)
