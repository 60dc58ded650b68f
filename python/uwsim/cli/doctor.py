"""`uwsim doctor`: find out why ROS and the simulator do not see each other."""

from __future__ import annotations

import os
from typing import Annotated

import typer

from uwsim.cli.bounds import within
from uwsim.cli.bridges import RosDistro, RosDomain, RosPeers, RosReach, need_subnet

MARKS = {"ok": "ok", "note": "-", "wrong": "WRONG"}


def doctor(
    ros_distro: RosDistro = None,
    ros_domain_id: RosDomain = None,
    ros_reach: RosReach = None,
    ros_peer: RosPeers = None,
    port: Annotated[
        int, typer.Option(help="Port of the rosbridge, running or planned.", callback=within(1, 65535))
    ] = 9090,
    foxglove_port: Annotated[int, typer.Option(help="Port for Foxglove.", callback=within(1, 65535))] = 8765,
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

    from uwsim.bridges.doctor import Plan, examine
    from uwsim.bridges.ros2.settings import settings_from

    need_subnet(ros_reach, ros_peer)
    settings = settings_from(
        os.environ, distro=ros_distro, domain_id=ros_domain_id, reach=ros_reach or "localhost", peers=ros_peer or ()
    )
    console, table = Console(), Table("", "", "found", "what to do", show_edge=False)
    wrong = 0
    with console.status(f"looking and listening for {listen:g} s"):
        for finding in examine(Plan(settings, port, foxglove_port, ardusub_port, listen), os.environ):
            wrong += finding.verdict == "wrong"
            table.add_row(MARKS[finding.verdict], finding.what, finding.found, finding.advice)
    console.print(table)
    console.print("nothing is wrong" if not wrong else f"{wrong} wrong")
    return 1 if wrong else 0
