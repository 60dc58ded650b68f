"""`uwsim teleop`: fly a vehicle from the terminal."""

from __future__ import annotations

from typing import Annotated

import typer

from uwsim.cli.options import Seed, SonarModel, Threads
from uwsim.cli.options import sonar_model as parsed_sonar_model


def teleop(
    url: Annotated[
        str | None, typer.Argument(help="A rosbridge, such as ws://host:9090. Default: a simulator of its own.")
    ] = None,
    scenario: Annotated[
        str | None, typer.Option(help="What its own simulator flies: a name or a YAML file. Default: lake.")
    ] = None,
    vehicle: Annotated[str | None, typer.Option(help="Which vehicle, where there are several. Default: the first.")] = (
        None
    ),
    seed: Seed = None,
    sonar_model: SonarModel = None,
    threads: Threads = None,
) -> None:
    """Fly a vehicle from the terminal, by keys or a gamepad.

    ? shows the keys; Ctrl-Q quits. Whatever ends it, the efforts are zero afterwards.
    """
    from uwsim.extras import need_extra

    need_extra("textual", "teleop", "uwsim teleop")
    from uwsim.teleop.fly import fly

    if url is not None:
        if (scenario, seed, sonar_model, threads) != (None, None, None, None):
            raise ValueError(
                "--scenario, --seed, --sonar-model and --threads are for a simulator of its own, not a URL"
            )
        marks, code = fly(url, url, vehicle)
    else:
        from uwsim.bridges import RosbridgeServer
        from uwsim.live import LiveSimulator
        from uwsim.simulator import Simulator

        flown = scenario or "lake"
        simulator = Simulator(flown, seed=seed, sonar_model=parsed_sonar_model(sonar_model), threads=threads)
        if vehicle is not None and vehicle not in simulator.vehicles:
            raise ValueError(f"--vehicle = {vehicle!r}: must be one of {', '.join(simulator.vehicles)}")
        with LiveSimulator(simulator) as live, RosbridgeServer(live, port=0) as server:
            marks, code = fly(server.url, flown, vehicle if len(simulator.vehicles) > 1 else None)
    for number, mark in enumerate(marks, 1):
        typer.echo(f"mark {number}: {mark}")
    raise typer.Exit(code)
