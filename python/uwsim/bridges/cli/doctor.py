"""`uwsim doctor`: find out why ROS and the simulator do not see each other."""

from __future__ import annotations

from typing import Annotated

import typer

from uwsim.bridges.requested import ExaminedBridges
from uwsim.cli.bounds import within
from uwsim.cli.groups import under

MARKS = {"ok": "ok", "note": "-", "wrong": "WRONG"}


@under("Connect")
def doctor(
    bridges: ExaminedBridges,
    port: Annotated[
        int, typer.Option(help="Port of the rosbridge, running or planned.", callback=within(1, 65535))
    ] = 9090,
    ardusub_port: Annotated[int, typer.Option(help="UDP port for ArduSub's frames.", callback=within(1, 65535))] = 9002,
    listen: Annotated[
        float, typer.Option(help="How long to listen for ROS 2 nodes [s].", callback=within(0.1, 60, "s"))
    ] = 3.0,
) -> int:
    """Diagnose why ROS and the simulator do not connect.

    Checks domain, interface, multicast, versions, ports and packages. Exits with 1 if something is wrong.
    """
    from rich.console import Console
    from rich.table import Table

    from uwsim.bridges.doctor import examine

    console, table = Console(), Table("", "", "found", "what to do", show_edge=False)
    wrong = 0
    with console.status(f"looking and listening for {listen:g} s"):
        for finding in examine(bridges, port, ardusub_port, listen):
            wrong += finding.verdict == "wrong"
            table.add_row(MARKS[finding.verdict], finding.what, finding.found, finding.advice)
    console.print(table)
    console.print("nothing is wrong" if not wrong else f"{wrong} wrong")
    return 1 if wrong else 0
