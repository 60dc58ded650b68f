"""`uwsim teleop`: fly a vehicle from the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.base.options import flag_name
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.cli.groups import under
from uwsim.cli.options import SimulatorOptions
from uwsim.cli.values import scenarios

if TYPE_CHECKING:
    from uwsim.bridges import RosbridgeServer
    from uwsim.simulator.simulator import Simulator


@under("Connect")
def teleop(
    *,
    url: Annotated[
        str | None, typer.Argument(help=f"A rosbridge, such as ws://host:{ROSBRIDGE_PORT}. Default: its own simulator.")
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            help="Scenario of its own simulator: a name or a YAML file. Default: lake.", autocompletion=scenarios
        ),
    ] = None,
    vehicle: Annotated[str | None, typer.Option(help="The vehicle, if there are several. Default: the first.")] = (
        None
    ),
    simulator: SimulatorOptions,
) -> None:
    """Fly a vehicle from the terminal with keys.

    ? shows the keys; Ctrl-Q quits. At the end, the efforts are always set to zero.
    """
    from uwsim.base.extras import need_extra

    need_extra("websockets", "uwsim teleop")
    from uwsim.operator.teleop.app import Screen
    from uwsim.operator.teleop.connection import Connection
    from uwsim.operator.teleop.hands import Hands

    if url is not None:
        given = [name for name, is_given in {"scenario": scenario is not None, **simulator.given()}.items() if is_given]
        if given:
            raise ValueError(f"{flag_name(given[0])}: is for its own simulator, not for a URL")
        code = Screen(Connection(url, Hands(), vehicle)).run()
    else:
        from uwsim.simulator.simulator import Simulator

        own = Simulator(scenario or "lake", **simulator.arguments)
        if vehicle is not None and vehicle not in own.vehicles:
            raise ValueError(f"--vehicle = {vehicle!r}: must be one of {', '.join(own.vehicles)}")
        with own_server(own) as server:
            code = Screen(Connection(server.url, Hands(), vehicle if len(own.vehicles) > 1 else None)).run()
    raise typer.Exit(code)


@contextmanager
def own_server(simulator: Simulator) -> Iterator[RosbridgeServer]:
    """Run and serve a simulator on a free local port, over its link if it has one.

    If the link is a modem, it carries the telemetry alone, unless the scenario selects the channels.
    """
    from uwsim.bridges import RosbridgeServer
    from uwsim.channels.served import served_table
    from uwsim.link import Carrier
    from uwsim.live import LiveSimulator

    with ExitStack() as ends:
        live = ends.enter_context(LiveSimulator(simulator))
        table = served_table(live, wire="both")  # not the scenario's, since the pilot needs the standard topics
        if simulator.link is not None:
            shown = ("telemetry",) if simulator.link.modem.kind == "modem" else None
            carrier = ends.enter_context(Carrier(live, table, only=shown))
            table.channels, table.services = carrier.channels, carrier.over(table.services)
        yield ends.enter_context(RosbridgeServer(live, channels=table.channels, services=table.services))
