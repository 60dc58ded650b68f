"""`uwsim scenario parameters`: the parameters of a scenario that can be changed while it runs."""

from __future__ import annotations

import json
from typing import Annotated, Any

import typer

from uwsim.cli.values import scenarios


def parameters(
    scenario: Annotated[
        str, typer.Argument(help="A packaged scenario, or the path of a YAML file.", autocompletion=scenarios)
    ],
    prefix: Annotated[str, typer.Argument(help="List only those at and below this name, such as rov.drag.")] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Write a JSON list instead of a table.")] = False,
) -> None:
    """List the parameters that may change during a run.

    Prints name, value, unit, range and description of each.

    `sim.parameters` sets them in Python; ROS clients set them as parameters (/rov/drag/linear/surge) or by services.
    """
    from dataclasses import asdict

    from uwsim.simulator.simulator import Simulator

    found = Simulator(scenario).parameters
    described = [found.describe(name) for name in found.list(prefix)]
    if as_json:
        typer.echo(json.dumps([asdict(each) for each in described], indent=2))
        return
    rows = [("name", "value", "unit", "range", "description")]
    rows += [(each.name, _shown(each.value), each.unit, each.range_text, each.description) for each in described]
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        typer.echo("  ".join([*cells, row[4]]).rstrip())


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else json.dumps(value)
