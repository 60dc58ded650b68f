"""`uwsim vehicle`: a report on a vehicle's file, in the terminal and as an HTML page, or a draft of the file."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.axes import AXES
from uwsim.base.own_files import require_own
from uwsim.cli.decompose import decompose
from uwsim.cli.exit_codes import FAILED
from uwsim.cli.groups import with_default
from uwsim.cli.options import print_json
from uwsim.cli.values import UsageError, one_of, vehicles, within, writable
from uwsim.evidence.cli.identify import identify
from uwsim.evidence.cli.tune import tune

if TYPE_CHECKING:
    from uwsim.simulator.simulator import Simulator

BOWS = ("x", "-x", "y", "-y")
UPS = (*BOWS, "z", "-z")
SHORT = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "in": "inches", "ft": "feet"}


app = with_default("vehicle", "Report how a vehicle moves; tune, identify, decompose it.", "Scenarios and maps")


@app.command("report")
def vehicle(
    file: Annotated[
        str,
        typer.Argument(
            help="A vehicle's YAML file, or the name of a packaged one; with --draft, a mesh: STL, OBJ, PLY, glTF, "
            "Collada (.dae), FBX or STEP.",
            autocompletion=vehicles,
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="The HTML page to write. Default: no page.", callback=writable)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    wet: Annotated[
        Path | None,
        typer.Option(
            help="A picture to write instead, .png: the hull's triangles that are under water as the vehicle floats "
            "upright in still water, or half under water if it sinks.",
            callback=writable,
        ),
    ] = None,
    draft: Annotated[bool, typer.Option("--draft", help="Print a vehicle's YAML file, estimated from a mesh.")] = False,
    axes: Annotated[
        str | None,
        typer.Option(
            help=f"Axes that the draft's thrusters drive, of {','.join(AXES)}. Default: surge,heave,yaw; blunt: sway."
        ),
    ] = None,
    mass_kg: Annotated[
        float | None, typer.Option(help="The draft's mass [kg]. Default: neutral.", callback=within(0.01, 1e6, "kg"))
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(
            help=f"The mesh's unit: {', '.join(SHORT)}. Default: guessed from its size or mass.", **one_of(*SHORT)
        ),
    ] = None,
    forward: Annotated[
        str | None,
        typer.Option(
            help=f"Direction of the mesh's bow: {', '.join(BOWS)}. Default: x, or y if longer.", **one_of(*BOWS)
        ),
    ] = None,
    up: Annotated[
        str | None,
        typer.Option(
            help=f"The mesh's axis that points up: {', '.join(UPS)}. Default: y for glTF, as declared for Collada and "
            "FBX, else z.",
            **one_of(*UPS),
        ),
    ] = None,
    length_m: Annotated[
        float | None,
        typer.Option(
            help="The length [m] of the mesh's longest side, instead of its unit.", callback=within(0.01, 500, "m")
        ),
    ] = None,
) -> None:
    """Report how a vehicle floats, moves and sees.

    Covers mass, buoyancy, trim and righting; added mass and drag beside estimates from the hull's shape (Lamb's
    ellipsoid, Hoerner, panels); a straight run, terminal speeds and turning circles; eigenvalues of its linear motion;
    the rank and authority of its thrusters; how much of its own hull each instrument sees; and, of a packaged one, what
    its makers and owners state. All values are for deep, still, fresh water. Exits with 1 if the file has a mistake.

    With --draft, `uwsim vehicle hull.stl --draft > mine.yaml` writes the file instead: mass, added mass (panels), drag
    (Hoerner, ITTC-57), thrusters, fins and sensors, each with its method and spread. `uwsim survey lake --vehicle-model
    mine.yaml` flies it.
    """
    if wet is not None and (draft or as_json or out is not None):
        raise UsageError("--wet draws a picture, not a report: leave out --draft, --out and --json")
    if wet is not None and wet.suffix != ".png":
        raise UsageError(f"--wet {wet}: must end in .png")
    options = {
        "mass_kg": mass_kg, "unit": unit and SHORT[unit], "forward": forward, "up": up, "length_m": length_m
    }  # fmt: skip
    if draft:
        if out is not None or as_json:
            raise UsageError("--draft prints a vehicle's file, not a report: leave out --out and --json")
        if unit is not None and length_m is not None:
            raise UsageError("--unit and --length-m both state the scale: leave out one")
        _print_draft(Path(file), axes, **options)
        return
    for option, value in {"axes": axes, **options}.items():
        if value is not None:
            raise UsageError(f"--{option.replace('_', '-')} has no effect without --draft")
    from uwsim.evidence.scenario_check import check_part
    from uwsim.evidence.vehicle.report import vehicle_report
    from uwsim.evidence.vehicle.text import report_lines, write_page

    if out is not None:
        require_own(out)  # before a minute's work
    check = check_part(file, "vehicle")
    for mistake in check.mistakes:
        typer.echo(f"uwsim: error: {mistake}", err=True)
    if check.simulator is None or check.vehicle is None:
        raise typer.Exit(FAILED)
    if wet is not None:
        _draw_wet(wet, check.simulator)
        return
    report = vehicle_report(check.simulator, check.vehicle)
    if as_json:
        print_json({**report.to_dict(), "warnings": check.warnings})
    else:
        typer.echo("\n".join([f"{check.file}: {report.model.name}", *report_lines(report)]))
    for warning in check.warnings:
        typer.echo(f"uwsim: warning: {warning}", err=True)
    if out is not None:
        write_page(out, report, check.warnings)
        typer.echo(f"page: {out}", err=as_json)


def _draw_wet(path: Path, sim: Simulator) -> None:
    """Draw the wet triangles of the first vehicle of a simulator in open water. Raises OSError."""
    from uwsim.evidence.vehicle.afloat import afloat
    from uwsim.figures.wet_triangles import draw_wet_triangles
    from uwsim.scenario.build.hull import vehicle_hull

    at = afloat(sim)
    model = sim.scenario.vehicles[0].model
    vertices, triangles = vehicle_hull(model)
    draw_wet_triangles(path, model.name, vertices[triangles], at.wet, at.water_z_m)
    how = "as it floats" if at.floats else "half under water: it does not float"
    typer.echo(f"{path}: {len(at.wet):,} triangles under water, {at.wet.area_m2:.3g} m2, {how}")


def _print_draft(mesh: Path, axes: str | None, **options: Any) -> None:
    """Print the draft, after it has been built once; progress, notes and warnings go to stderr."""
    chosen = None if axes is None else tuple(axis.strip() for axis in axes.split(","))
    if wrong := [axis for axis in chosen or () if axis not in AXES]:
        raise UsageError(f"--axes = '{wrong[0]}': must be of {', '.join(AXES)}")
    from uwsim.evidence.scenario_check import check_part
    from uwsim.exchange.hulls.draft import drafted

    def progress(line: str) -> None:
        typer.echo(f"uwsim: {line}", err=True)

    made = drafted(mesh, chosen, progress=progress, **options)
    with TemporaryDirectory() as folder:
        (path := Path(folder) / "draft.yaml").write_text(made.text, encoding="utf-8")
        check = check_part(path, "vehicle")
    for mistake in check.mistakes:
        typer.echo(f"uwsim: error: {mistake.replace(str(path), 'draft')}", err=True)
    if check.mistakes:
        raise typer.Exit(FAILED)
    for note in made.notes:
        progress(note)
    for warning in dict.fromkeys((*made.doubts, *check.warnings)):
        typer.echo(f"uwsim: warning: {warning}", err=True)
    typer.echo(made.text, nl=False)


for subcommand in (tune, decompose, identify):
    app.command()(subcommand)
