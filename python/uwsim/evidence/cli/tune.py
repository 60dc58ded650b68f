"""`uwsim vehicle tune`: search for gains of a vehicle's control loops."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.cli.options import AsJson, print_json
from uwsim.cli.values import vehicles, within

if TYPE_CHECKING:
    from uwsim.evidence.tuning import Tuned


def tune(
    file: Annotated[
        str, typer.Argument(help="A vehicle's YAML file, or the name of a packaged one.", autocompletion=vehicles)
    ],
    out: Annotated[Path, typer.Option(help="Folder for control.yaml and steps.png, before and after.")] = Path("tuned"),
    generations: Annotated[int, typer.Option(help="Generations of the search.", callback=within(0, 1000))] = 12,
    population: Annotated[
        int, typer.Option(help="Sets of gains in a generation, per gain.", callback=within(1, 100))
    ] = 6,
    as_json: AsJson = False,
) -> None:
    """Tune a vehicle's `control:` block.

    Searches for one set of gains for surge, sway and heave and one for roll, pitch and yaw, by differential evolution
    over steps in still water and a minute in gusts. Prints the block for the vehicle's file; axes that nothing drives
    are left out and named. By default it flies some 500 sets of gains, which takes minutes.
    """
    from uwsim.base.atomic_file import write_atomically
    from uwsim.evidence.tuning import control_text
    from uwsim.evidence.tuning import tune as tuned
    from uwsim.evidence.validate.report import draw_curves
    from uwsim.scenario import load_vehicle

    model = load_vehicle(file)
    found = tuned(
        model,
        generations=generations,
        population=population,
        hear=lambda gains: typer.echo(f"best so far: {', '.join(f'{gain:.2f}' for gain in gains)}", err=True),
    )
    block = control_text(found)
    if as_json:
        flights = {
            name: {"cost": flown.cost, "drift_rms_m": flown.drift_m, "roughness_rms": flown.roughness}
            for name, flown in (("before", found.before), ("after", found.after))
        }
        control = found.model.control.model_dump(mode="json", exclude=set(found.left_out))
        print_json({"control": control, "left_out": found.left_out, **flights})
    else:
        _print(found, block)
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / "control.yaml", f"{block}\n".encode())
    responses = zip(found.after.responses, found.before.responses, strict=True)
    draw_curves([after.curve(before) for after, before in responses], out / "steps.png", model.name)
    typer.echo(f"figure: {out / 'steps.png'}", err=True)


def _print(found: Tuned, block: str) -> None:
    for name, flown in (("before", found.before), ("after", found.after)):
        gusts = "" if flown.drift_m is None else f"; in gusts {flown.drift_m:.3f} m rms, "
        gusts += "" if flown.roughness is None else f"efforts change by {flown.roughness:.3f} rms a period"
        typer.echo(f"# {name}: cost {flown.cost:.3f}{gusts}")
    if found.left_out:
        typer.echo(f"# nothing drives {', '.join(found.left_out)}: left out")
    if found.after is found.before:
        typer.echo("# no better gains were found: these are the file's own")
    typer.echo(block)
