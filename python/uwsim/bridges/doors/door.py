"""Door: the sockets that an option opens, as each bridge's plug states them for the table in SECURITY.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LOOPBACK, ANYWHERE, HOST = "127.0.0.1", "all addresses", "`--host`, by default 127.0.0.1"
OWN = "its own, by default 127.0.0.1"
IF_LOCAL = "127.0.0.1 if the target is local, else all addresses"
WEB = "pages of this machine and `--page`, other programs; with `--token` only who sends it; `--certfile` encrypts"
EVERYONE = "every program that reaches the address"


@dataclass(frozen=True)
class Door:
    """Sockets on which a program receives. option: what opens them; names: whom they serve.

    count: how many they are, by default; 0 for an option that opens none, since it only connects to others. address:
    where they listen. admits: who may enter, and how that is limited. example: options of `uwsim serve` that open them,
    by which a test compares the door with the sockets that are open. speaks_first: whether who only listens is served.
    """

    option: str
    protocol: Literal["TCP", "UDP"]
    count: int
    address: str
    serves: str
    admits: str
    example: tuple[str, ...] = ()
    speaks_first: bool = False
