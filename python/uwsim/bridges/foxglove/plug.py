"""`--foxglove`: a live simulator or a recording for the Foxglove app."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from uwsim.bridges.doors.door import HOST, WEB, Door
from uwsim.bridges.foxglove.options import FoxgloveOptions
from uwsim.bridges.plug import BridgePlug, Context, Opened


class FoxglovePlug(BridgePlug[FoxgloveOptions]):
    """The Foxglove server. Raises MissingExtraError."""

    options = FoxgloveOptions
    doors = (Door("`--foxglove`", "TCP", 1, HOST, "Foxglove", WEB, ("--foxglove", "--foxglove-port", "0")),)

    def __init__(self, options: FoxgloveOptions) -> None:
        super().__init__(options)
        from uwsim.base.extras import need_extra

        need_extra("foxglove", "Foxglove")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Run the server."""
        from uwsim.bridges.foxglove.server import FoxgloveServer

        with FoxgloveServer(
            context.live,
            context.channels,
            context.services,
            port=self.given.port,
            feed=context.feed,
            origin=context.origin,
            **context.access,
        ) as server:
            yield Opened(f"Foxglove at {server.url}", server)
