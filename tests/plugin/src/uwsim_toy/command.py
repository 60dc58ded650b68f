"""`uwsim toy`: the sensors of each vehicle."""

from __future__ import annotations

from typing import Annotated

import typer

from uwsim.cli.values import scenarios


def toy(
    scenario: Annotated[str, typer.Argument(help="Name of a scenario.", autocompletion=scenarios)] = "pool",
) -> None:
    """List the sensors of each vehicle of a scenario."""
    from uwsim import Simulator  # inside, since `uwsim --help` imports this module

    with Simulator(scenario) as simulator:
        for name, vehicle in simulator.vehicles.items():
            typer.echo(f"{name}: {', '.join(vehicle.sensors)}")
