"""`uwsim reproduce`: reproduce published figures and numbers."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import need
from uwsim.cli.groups import under
from uwsim.cli.values import one_of


@under("Check")
def reproduce(
    what: Annotated[
        str,
        typer.Argument(help="What to reproduce: paper, its figures.", **one_of("paper")),
    ] = "paper",
    source: Annotated[
        Path | None,
        typer.Option(
            "--from",
            help="A checkout of the paper's Unity project: its own terrain, station, gates and vehicle beside ours, "
            "with a number for each figure, as a folder to deposit.",
            show_default=False,
        ),
    ] = None,
    scene: Annotated[
        str | None, typer.Option(help="With --from: the scene, by its file's name without .unity. Default: LawnTest.")
    ] = None,
    terrain: Annotated[
        str | None, typer.Option(help="With --from: the top-level object that is the bed. Default: SolidTerrain.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder for the files; with --from, new or empty. Default: named as WHAT.", show_default=False
        ),
    ] = None,
) -> None:
    """Reproduce the paper's figures.

    Writes fig01.png to fig12.png, the values behind them (figures.json), and index.html. With --from,
    each picture is drawn twice, from the authors' own files and from the packaged scenario; README.md has the table of
    numbers, and manifest.json the command, the versions, the seed, and the hashes of all inputs and outputs.

    The paper: Akash Chaudhary, Rajat Mishra, Bharath Kalyan and Mandar Chitre, "Development of an Underwater Simulator
    using Unity3D and Robot Operating System", OCEANS 2021 MTS/IEEE, 2021. Its project and nodes, for which we thank
    them: https://github.com/org-arl/UWRoboticsSimulator
    """
    out = Path(what) if out is None else out
    if source is None:
        need("--from", scene=scene, terrain=terrain)
        from uwsim.evidence.reproduce import reproduce_paper

        reproduce_paper(out, typer.echo)
        return
    from uwsim.evidence.reproduce.beside import reproduce_beside

    given = {key: value for key, value in (("scene", scene), ("terrain", terrain)) if value is not None}
    words = ["uwsim", "reproduce", what, "--from", str(source), "--out", str(out)]
    words += [word for key, value in given.items() for word in (f"--{key}", value)]
    numbers = reproduce_beside(source, out, given, shlex.join(words), typer.echo)
    typer.echo(f"{out / 'README.md'}: {sum(each.held for each in numbers)} of {len(numbers)} claims held")
