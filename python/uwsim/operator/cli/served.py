"""`uwsim serve --station`: the operator's page of one running simulator."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import option
from uwsim.bridges.page import Page, Serving, page_url

if TYPE_CHECKING:
    from uwsim.channels import Table


@dataclass(frozen=True)
class StationPage(Page):
    """The options of the operator's page."""

    switch = "station"

    station: bool = option(False, "Also serve the operator's page.")
    keep_flights: str | None = option(
        None,
        "With --station: record each session separately in the folder flights, as `uwsim station` does, and "
        "keep this many flights, and this many MB. Default: none.",
        metavar="COUNT,MB",
    )

    def open(self, stack: ExitStack, serving: Serving) -> tuple[str, str, Table]:
        """Open the server, which the stack closes; return its address, the page's for the greeting, and the table."""
        from uwsim.operator.cli.station import kept_flights, station_server
        from uwsim.operator.station import Station

        bounds = None if self.keep_flights is None else kept_flights(self.keep_flights)
        hub = Station(is_fixed=True, wire=serving.wire or "both", origin=serving.origin, keep_flights=bounds)  # type: ignore[arg-type]  # checked there
        server = stack.enter_context(station_server(hub, **serving.server))
        hub.run(lambda: serving.live, lambda running: serving.record(running.table), serving.feed)
        place = f"the station's page at {page_url(server.url, serving.token)}"
        return server.url, place, hub.present().table
