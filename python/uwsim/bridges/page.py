"""A page for the socket `uwsim.pages`: `uwsim serve` serves it on the same port as its rosbridge clients."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Options, RegisteredOptions

if TYPE_CHECKING:
    from uwsim.channels import Table
    from uwsim.channels.delivery.feed import Feed
    from uwsim.live import LiveSimulator


@dataclass(frozen=True)
class Serving:
    """The context in which a page is served.

    server: the arguments of the RosbridgeServer. wire, origin: as for a Table. token: the one that the page's address
    may show. record: starts the requested recording of a table, if there is one.
    """

    live: LiveSimulator
    feed: Feed
    server: Mapping[str, Any]
    wire: str | None
    origin: str
    token: str | None
    record: Callable[[Table], None]


class Page(Options):
    """The base of a page's options. Its switch requests the page."""

    def open(self, stack: ExitStack, serving: Serving) -> tuple[str, str, Table]:
        """Open the server, which the stack closes; return its address, the page's for the greeting, and the table."""
        raise NotImplementedError


class Pages(RegisteredOptions[Page]):
    """The options of all pages that are registered; at most one is requested."""

    socket = "uwsim.pages"
    base = Page


def page_url(server_url: str, token: str | None) -> str:
    """Return the address of a page."""
    return server_url.replace("ws", "http", 1) + (f"/?token={token}" if token else "/")
