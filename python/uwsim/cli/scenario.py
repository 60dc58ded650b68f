"""`uwsim scenario`: list, create and check scenarios, and print their schemas."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from uwsim.base.named import did_you_mean
from uwsim.cli.groups import show_help
from uwsim.cli.options import SETTINGS, AsJson, print_json
from uwsim.cli.values import UsageError, scenarios, words

KINDS = ("scenario", "vehicle", "thruster", "sonar", "sensors", "modem", "battery")


class ScenarioCommands(TyperGroup):
    """The scenario commands; for a scenario's name in place of a command, the error suggests the right command."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, command and arguments. Raises UsageError."""
        if not ctx.resilient_parsing and args[0] not in self.commands:
            meant = did_you_mean(args[0], self.commands)
            check = f"; to check a scenario: uwsim scenario check {args[0]}"
            raise UsageError(f"No such command 'scenario {args[0]}'{meant or check}")
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="uwsim scenario",
    cls=ScenarioCommands,
    help="List, create, check and examine scenarios; print their schemas.",
    invoke_without_command=True,
    callback=show_help,
    rich_help_panel="Scenarios and maps",
    **SETTINGS,
)


@app.command("list")
def list_scenarios(as_json: AsJson = False) -> None:
    """List the packaged scenarios."""
    from uwsim.scenario import load, packaged_scenarios

    found: list[dict[str, Any]] = [
        {
            "name": scenario.name,
            "description": " ".join(scenario.description.split()),
            "vehicles": {vehicle.name: vehicle.model.name for vehicle in scenario.vehicles},
            "obstacles": len(scenario.obstacles),
            "seed": scenario.seed,
        }
        for scenario in map(load, packaged_scenarios())
    ]
    if as_json:
        print_json(found)
        return
    for each in found:
        vehicles = ", ".join(f"{name} ({model})" for name, model in each["vehicles"].items())
        typer.echo(f"{each['name']}: {each['description']}")
        typer.echo(f"  vehicles: {vehicles}; obstacles: {each['obstacles']}; seed {each['seed']}")


@app.command()
def new(
    name: Annotated[str, typer.Argument(help="Name of the scenario; the file is NAME.yaml.")],
    out: Annotated[Path | None, typer.Option(help="The file to write, instead of NAME.yaml.")] = None,
    like: Annotated[
        str | None,
        typer.Option(help="A packaged scenario to start from. Default: a template.", autocompletion=scenarios),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file if there is one.")] = False,
) -> None:
    """Create a scenario file to start from.

    It is commented and ready to run. Its first line names the packaged schema, so that editors with a YAML language
    server complete and check it.
    """
    from uwsim.scenario.dump import new_scenario

    try:
        path = new_scenario(name, out, like, overwrite=force)
    except FileExistsError as error:
        raise FileExistsError(f"{error.filename}: exists already; --force overwrites it") from None
    typer.echo(f"{path}: edit it, then uwsim scenario check {path}")


@app.command()
def schema(
    part: Annotated[
        str,
        typer.Argument(
            help="scenario, vehicle, thruster, sonar, sensors, modem, battery; exercise; or sensor, camera, fault ...",
            autocompletion=words(*KINDS, "exercise"),
        ),
    ] = "scenario",
    path: Annotated[bool, typer.Option("--path", help="Print the packaged file's path, for an editor.")] = False,
) -> None:
    """Print the JSON Schema of scenarios or a part.

    Draft 7, for editors and other programs.
    """
    from pydantic import BaseModel

    from uwsim.base.sockets import load_all
    from uwsim.scenario.schema import FILES, schema_file
    from uwsim.scenario.schema import schema as schema_of

    def model(name: str, found: Any) -> Any:
        if not (isinstance(found, type) and issubclass(found, BaseModel)):
            raise TypeError("must be a class derived from pydantic.BaseModel")
        return found

    if not path:
        typer.echo(json.dumps(schema_of(part, dict(load_all("uwsim.schemas", model))), indent=2))
        return
    if part not in FILES:
        raise ValueError(f"part '{part}': only {', '.join(FILES)} are files of their own")
    typer.echo(str(schema_file(part)))
