"""`uwsim ros nodes`: the paper's processing chain as ROS nodes over rosbridge."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import need
from uwsim.bridges.cli.connect import ServersRos
from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import FAILED

NODES = ("string_decoder", "scan_publisher", "laser_to_cloud", "tf_broadcaster", "parameter_decoder", "octomap")


def nodes(
    name: Annotated[
        str,
        typer.Argument(
            help=f"{', '.join(NODES)}; or all, one process each.",
            **one_of("all", *NODES),
        ),
    ] = "all",
    url: Annotated[str, typer.Option(help="The rosbridge, such as that of uwsim serve --wire published.")] = (
        "ws://127.0.0.1:9090"
    ),
    out: Annotated[Path | None, typer.Option(help="Map file of the octomap node. Default: nodes.bt.")] = None,
    patience: Annotated[
        float, typer.Option(help="How long to wait for the rosbridge [s].", callback=within(0, 86_400, "s"))
    ] = 10.0,
    ros: ServersRos = None,
    published_types: Annotated[
        bool,
        typer.Option(
            "--published-types", help="Publish arrays as the paper's misc/floatarray; ROS then needs its package."
        ),
    ] = False,
) -> None:
    """Run the paper's mapping pipeline as nodes over rosbridge.

    The nodes convert depth strings and poses into a map file, and the panel's string into numbers. Ctrl-C stops them.

    They reconnect whenever the connection is lost. The map is saved then, every second or less often, and at the end.

    The simulator's standard topics have the same names, so run uwsim serve --wire published.
    """
    import logging

    from uwsim.bridges.nodes.chain import FLOATS, PUBLISHED_FLOATS
    from uwsim.bridges.nodes.processes import run_all, run_one
    from uwsim.channels.ros.message_types import Ros
    from uwsim.mapping.occupancy_map import require_map_path

    if name not in ("octomap", "all"):
        need("the node octomap", out=out)
    out = out or Path("nodes.bt")
    if name in ("octomap", "all"):
        require_map_path(out)  # now, since a map that cannot be written at the end is lost
    generation: Ros | None = None if ros is None else 2 if ros == 2 else 1
    floats = PUBLISHED_FLOATS if published_types else FLOATS
    logging.basicConfig(format="%(name)s: %(message)s")
    if name != "all":
        run_one(name, url, out, patience, lambda: typer.echo(f"{name} at {url}"), floats, generation)
        return
    notice = f"{', '.join(NODES)} at {url}; Ctrl-C ends them"
    if not run_all(url, out, patience, lambda: typer.echo(notice), floats, generation):
        raise typer.Exit(FAILED)
