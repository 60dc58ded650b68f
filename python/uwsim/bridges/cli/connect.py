"""`uwsim ros connect`: join a live simulator to a ROS graph through a rosbridge_server."""

from __future__ import annotations

from typing import Annotated

import typer

from uwsim.bridges.cli.graph_options import GraphOptions
from uwsim.bridges.cli.serve import FramePrefix, Namespace, Origin, Paused, Speed, Tf, parsed_speed, prefix_of
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.cli.options import SimulatorOptions
from uwsim.cli.values import one_of, scenarios, within

ServersRos = Annotated[
    int | None,
    typer.Option(
        help="The server's generation of ROS, 1 or 2, if it does not show it. Default: 1.", callback=within(1, 2)
    ),
]


def connect(
    *,
    url: Annotated[str, typer.Argument(help=f"The rosbridge_server, such as ws://localhost:{ROSBRIDGE_PORT}.")],
    scenario: Annotated[
        str, typer.Argument(help="Name of a packaged scenario, or path of a YAML file.", autocompletion=scenarios)
    ] = "lake",
    speed: Speed = "1",
    simulated: SimulatorOptions,
    wire: Annotated[
        str,
        typer.Option(
            help="Topics: standard (ROS's usual ones), published (those of the paper's simulator) or both.",
            **one_of("standard", "published", "both"),
        ),
    ] = "published",
    origin: Origin = None,
    namespace: Namespace = "",
    frame_prefix: FramePrefix = None,
    tf: Tf = "truth",
    graph: GraphOptions,
    ros: ServersRos = None,
    paused: Paused = False,
) -> None:
    """Run a scenario as a client of a rosbridge_server.

    The paper's simulator connects in the same way. Ctrl-C stops it.

    It reconnects whenever the connection is lost, and asks the server whether it is of ROS 1 or 2. Every topic is sent
    at its full rate, because rosbridge does not report whether it has subscribers.
    """
    import logging
    from contextlib import ExitStack

    from uwsim.bridges import RosbridgeClient
    from uwsim.bridges.doors.dialler import checked_url
    from uwsim.channels import Table, diagnostics_channel
    from uwsim.channels.names import channels_in, node_name, services_in
    from uwsim.channels.served import default_origin
    from uwsim.cli.run_live import run_until_interrupted
    from uwsim.live import LiveSimulator
    from uwsim.simulator.simulator import Simulator

    logging.basicConfig(format="uwsim: %(message)s")
    logging.getLogger("uwsim.rosbridge").setLevel(logging.INFO)
    prefix = prefix_of(namespace, frame_prefix)
    parameters = graph.parameters(node_name(namespace))
    checked_url(url)  # before the scenario is built
    simulator = Simulator(scenario, **simulated.arguments)
    graph.apply(parameters, simulator)
    live = LiveSimulator(simulator, speed=parsed_speed(speed), paused=paused)
    table = Table(
        simulator,
        wire=wire,  # type: ignore[arg-type]  # checked there
        origin=origin or default_origin(simulator.scenario),
        may_wait=lambda: live.speed == "max",  # in real time, the pace has priority
        is_behind=lambda: live.is_behind,
        tf=tf,  # type: ignore[arg-type]  # checked there
        frame_prefix=prefix,
        **graph.of_table,
    )
    if wire != "published":
        table.channels.append(diagnostics_channel(live, lambda: table.channels))
    with live, ExitStack() as sinks:
        if simulator.link is not None:
            from uwsim.link import Carrier

            carrier = sinks.enter_context(Carrier(live, table))
            table.channels, table.services = carrier.channels, carrier.over(table.services)
        # The server reports no readers: what is sent on request only, and not once, would always be sent.
        sent = [
            each
            for each in table.channels
            if each.direction == "in" or each.delivery.latched or not each.delivery.on_request
        ]
        named = {"channels": channels_in(namespace, sent), "services": services_in(namespace, table.services)}
        joined = RosbridgeClient(live, url, ros=ros, **named)  # type: ignore[arg-type]  # bounded
        client = sinks.enter_context(joined).client
        run_until_interrupted(live, f"{scenario} to {url}")
        if client.is_refused:
            raise ValueError(f"{url}: {client.trouble}")
