"""`uwsim station`: the operator's station, a web page for choosing a scenario, flying and mapping."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.bridges.cli.serve import Origin, Wire
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.page import page_url
from uwsim.cli.access import Access
from uwsim.cli.groups import under
from uwsim.cli.options import Threads
from uwsim.cli.values import modems, scenarios, within

if TYPE_CHECKING:
    from uwsim.bridges import RosbridgeServer
    from uwsim.operator.station import Station
    from uwsim.operator.station.flights.flights import Bounds

Truth = Annotated[
    bool, typer.Option("--truth/--no-truth", help="Show pilots the true position, or only the instruments' values.")
]

KeepFlights = Annotated[
    str,
    typer.Option(
        metavar="COUNT,MB",
        help="How many flights, and how many MB, are kept in the folder flights; each is recorded separately, "
        "and the oldest are deleted first. 0,1 records none.",
    ),
]
KEPT = "50,2000"


@under("Connect")
def station(
    *,
    scenario: Annotated[
        str,
        typer.Argument(
            help="Scenario preselected on the start screen: a name or a YAML file.", autocompletion=scenarios
        ),
    ] = "tarn",
    port: Annotated[
        int, typer.Option(help="Port to listen on; 0 chooses a free one.", callback=within(0, 65535))
    ] = ROSBRIDGE_PORT,
    host: Annotated[str, typer.Option(help="Address to listen on. Warns about any that other machines can reach.")] = (
        "127.0.0.1"
    ),
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Whether to open the page.")] = True,
    link: Annotated[
        str | None,
        typer.Option(help="Modem preselected on the start screen: a packaged one's name.", autocompletion=modems),
    ] = None,
    truth: Truth = True,
    wire: Wire = None,
    origin: Origin = None,
    access: Access,
    keep_flights: KeepFlights = KEPT,
    threads: Threads = None,
) -> None:
    """Serve the operator's station, a web page, and open it.

    It works offline and over a forwarded port. The same port also serves rosbridge clients. Ctrl-C stops it.
    """
    from uwsim.cli.run_live import wait_for_interrupt
    from uwsim.operator.framed import has_display
    from uwsim.operator.station import Station
    from uwsim.scenario import load
    from uwsim.scenario.read.assets import packaged_names

    accessible = access.settings(host)
    load(scenario)  # reports mistakes here instead of on the page
    if link is not None and link not in packaged_names("modems"):
        raise ValueError(f"--link = {link!r}: must be one of {', '.join(packaged_names('modems'))}")
    hub = Station(
        offered=scenario,
        link=link,
        truth=truth,
        wire=wire or "both",  # type: ignore[arg-type]  # checked there
        origin=origin,
        threads=threads,
        keep_flights=kept_flights(keep_flights),
    )
    with station_server(hub, port=port, **accessible) as server:
        # without a token from a file, since a browser's options are visible, too
        url = page_url(server.url, access.token)
        if browser and has_display():
            webbrowser.open(url)
        wait_for_interrupt(f"the station is at {url}; Ctrl-C ends it")


@contextmanager
def station_server(hub: Station, **settings: Any) -> Iterator[RosbridgeServer]:
    """Serve a station's page and rosbridge clients on one port. settings: those of the RosbridgeServer."""
    from uwsim.bridges import RosbridgeServer
    from uwsim.bridges.doors.admission import has_token
    from uwsim.operator.station import Site

    token = settings["token"]
    site = Site(hub, lambda request: token is None or has_token(request, token))
    with RosbridgeServer(None, guests=[hub], site=site, **settings) as server, hub.serving(server.show):
        yield server


def kept_flights(text: str) -> Bounds:
    """Return the bounds given by --keep-flights. Raises ValueError."""
    from uwsim.operator.station.flights.flights import Bounds

    try:
        return Bounds.of(text)
    except ValueError as error:
        raise ValueError(f"--keep-flights = {error}") from None
