"""`uwsim reproduce`: reproduce published figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.choices import one_of
from uwsim.cli.groups import under


@under("Check")
def reproduce(
    what: Annotated[str, typer.Argument(help="What to reproduce: paper.", **one_of("paper"))] = "paper",
    out: Annotated[Path, typer.Option(help="Folder for the pictures, their values and the page.")] = Path("paper"),
) -> None:
    """Reproduce the paper's figures with uwsim.

    Writes fig01.png to fig12.png, the values behind them (figures.json), and index.html.

    The paper: Akash Chaudhary, Rajat Mishra, Bharath Kalyan and Mandar Chitre, "Development of an Underwater Simulator
    using Unity3D and Robot Operating System", OCEANS 2021 MTS/IEEE, 2021. Its project and nodes, for which we thank
    them: https://github.com/org-arl/UWRoboticsSimulator
    """
    from uwsim.evidence.reproduce import reproduce_paper

    reproduce_paper(out, typer.echo)
