"""`uwsim scenario`: list the packaged scenarios, or check one."""

from __future__ import annotations

from typing import Annotated

import typer


def scenario(
    name: Annotated[str | None, typer.Argument(help="A scenario to check. Default: list all packaged ones.")] = None,
) -> None:
    """List the packaged scenarios, or check one and describe it.

    The check is complete: it builds the world and the vehicles.
    """
    from uwsim.scenario import load, packaged_scenarios
    from uwsim.simulator import Simulator

    for each in packaged_scenarios() if name is None else [name]:
        checked = load(each)
        if name is not None:
            Simulator(checked)
        sonars = ", ".join(
            f"{v.name} with sonar model {v.sonar.title}" if v.model.sonar else f"{v.name} without a sonar"
            for v in checked.vehicles
        )
        typer.echo(f"{checked.name}: {' '.join(checked.description.split())}")
        typer.echo(f"  vehicles: {sonars}; obstacles: {len(checked.obstacles)}; seed {checked.seed}")
