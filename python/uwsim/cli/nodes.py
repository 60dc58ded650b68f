"""`uwsim nodes`: the paper's chain as ROS nodes over rosbridge."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer


def nodes(
    name: Annotated[
        str,
        typer.Argument(
            help="string_decoder, scan_publisher, laser_to_cloud, tf_broadcaster, octomap; or all, each a process."
        ),
    ] = "all",
    url: Annotated[str, typer.Option(help="The rosbridge, such as that of uwsim serve --wire published.")] = (
        "ws://127.0.0.1:9090"
    ),
    out: Annotated[Path, typer.Option(help="Where the octomap node writes its map.")] = Path("nodes.bt"),
    patience: Annotated[float, typer.Option(help="How long to wait for the rosbridge [s].")] = 10.0,
) -> None:
    """Run the paper's chain as nodes: depth strings and poses in, a saved map out. Ctrl-C ends them.

    The simulator's own topics have the same names: use uwsim serve --wire published.
    """
    from uwsim.bridges.nodes.chain import NODES
    from uwsim.bridges.nodes.node import connect_patiently

    if name not in (*NODES, "all"):
        raise ValueError(f"node '{name}': unknown; there are: all, {', '.join(NODES)}")
    if name != "all":
        node = connect_patiently(url, patience)
        NODES[name](node, out)
        typer.echo(f"{name} at {url}")
        node.spin()
        return
    connect_patiently(url, patience).close()
    options = ["--url", url, "--out", str(out), "--patience", str(patience)]
    program = [sys.executable, "-c", "from uwsim.cli import main; main()", "nodes"]
    processes = [subprocess.Popen([*program, each, *options]) for each in NODES]
    try:
        codes = [process.wait() for process in processes]
    finally:
        for process in processes:
            process.terminate()
    if any(codes):
        raise typer.Exit(1)
