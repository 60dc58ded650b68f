"""`uwsim scenario link`: test a link, and draw delay, delivery and goodput against range and time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import within
from uwsim.cli.options import AsJson, ScenarioName, Seed, print_json
from uwsim.cli.values import modems


def link(
    scenario: ScenarioName = "lake",
    out: Annotated[Path, typer.Option(help="The figure to write, a PNG.")] = Path("link.png"),
    modem: Annotated[
        str | None,
        typer.Option(
            help="Name of a packaged modem, or a YAML file. Default: the scenario's link, else s2cm_hs.",
            autocompletion=modems,
        ),
    ] = None,
    depth: Annotated[float, typer.Option(help="Depth of the vehicle [m].", callback=within(0.5, 10_000, "m"))] = 10.0,
    seed: Seed = None,
    as_json: AsJson = False,
) -> None:
    """Test a link with a vehicle that moves away from a station.

    Its modem sends as much data as it can. Draws delay, delivery and goodput against range and time, and the sonar
    equation's prediction for open water.
    """
    from uwsim.link.trial import run_trial, summary
    from uwsim.link.trial_figure import draw_link_trial
    from uwsim.scenario import load
    from uwsim.simulator.link_traffic import text_table

    if not 0.5 <= depth <= 10_000:
        raise ValueError(f"--depth = {depth:g} m: must be in [0.5, 10000] m")
    loaded = load(scenario)
    trial = run_trial(loaded, modem or (None if loaded.link else "s2cm_hs"), seed=seed, depth_m=depth)
    draw_link_trial(trial, out)
    if as_json:
        values = {name: getattr(trial, name) for name in ("modem", "message_bytes", "legs", "open_water")}
        traffic = [row._asdict() for row in trial.table]
        print_json({"scenario": trial.scenario.name, **values, "table": traffic})
        return
    typer.echo(text_table(trial.table))
    typer.echo(summary(trial))
    typer.echo(f"delay, delivery and goodput against range and time: {out}")
