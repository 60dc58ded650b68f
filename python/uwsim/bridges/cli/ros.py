"""`uwsim ros`: what ROS needs beside `uwsim serve`, such as the packages for a workspace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.bridges.cli.connect import connect
from uwsim.bridges.cli.doctor import doctor
from uwsim.cli.groups import show_help
from uwsim.cli.options import SETTINGS
from uwsim.cli.values import scenarios

app = typer.Typer(
    name="uwsim ros",
    help="Join a ROS graph, diagnose the connection, write packages.",
    invoke_without_command=True,
    callback=show_help,
    rich_help_panel="Connect",
    **SETTINGS,
)


@app.command()
def package(
    out: Annotated[Path, typer.Option(help="The folder to write: new, empty, or written by this command.")] = Path(
        "uwsim_ros"
    ),
    scenario: Annotated[
        str,
        typer.Option(
            help="The scenario whose vehicles get a URDF, and which the launch file starts: a packaged one, or the "
            "path of a YAML file.",
            autocompletion=scenarios,
        ),
    ] = "lake",
) -> None:
    """Write ROS packages with uwsim's messages, vehicles as URDF, launch files and an RViz configuration.

    The folder has ros1/ for catkin and ros2/ for ament, each with uwsim_msgs, uwsim_description and uwsim_bringup, and
    a README with the hashes of the messages.
    """
    from uwsim.bridges.ros_packages import ros_packages, write_sealed

    files = ros_packages(scenario)
    write_sealed(out, files)
    typer.echo(f"{out}: {len(files)} files; copy ros1 or ros2 into the src folder of your workspace")


app.command()(doctor)
app.command()(connect)
