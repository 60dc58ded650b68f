"""`uwsim reproduce`: reproduce published figures and numbers."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import OptionError, need, refuse
from uwsim.cli.bounds import readable
from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import FAILED
from uwsim.cli.groups import under


@under("Check")
def reproduce(
    what: Annotated[
        str,
        typer.Argument(
            help="What to reproduce: paper, its figures, or claims, the numbers that other simulators print.",
            **one_of("paper", "claims"),
        ),
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
    quick: Annotated[bool, typer.Option("--quick", help="Claims: leave out those that measure time.")] = False,
    page: Annotated[
        Path | None,
        typer.Option(help="Claims: a Markdown file, to put the table between its marks.", callback=readable),
    ] = None,
) -> None:
    """Reproduce the paper's figures, or other simulators' numbers.

    For the paper, writes fig01.png to fig12.png, the values behind them (figures.json), and index.html. With --from,
    each picture is drawn twice, from the authors' own files and from the packaged scenario; README.md has the table of
    numbers, and manifest.json the command, the versions, the seed, and the hashes of all inputs and outputs.

    For claims, each number is computed now, and compared with the one that is printed in the other simulator's
    publication or files; writes claims.md and claims.json. Exits with 1 if a verdict is no longer the one in
    assets/claims/simulators.yaml; those that measure time do not count.

    The paper: Akash Chaudhary, Rajat Mishra, Bharath Kalyan and Mandar Chitre, "Development of an Underwater Simulator
    using Unity3D and Robot Operating System", OCEANS 2021 MTS/IEEE, 2021. Its project and nodes, for which we thank
    them: https://github.com/org-arl/UWRoboticsSimulator
    """
    out = Path(what) if out is None else out
    if what == "claims":
        refuse("is not for claims", source=source, scene=scene, terrain=terrain)
        if quick and page is not None:
            raise OptionError("--page: needs all claims, without --quick")
        _claims(out, quick, page)
        return
    refuse("is for claims", quick=quick or None, page=page)
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


def _claims(out: Path, quick: bool, page: Path | None) -> None:
    from uwsim.evidence.reproduce.claims import reproduce_claims

    made = reproduce_claims(out, quick=quick, page=page, progress=typer.echo)
    agree = sum(each.verdict == "agrees" for each in made)
    typer.echo(f"{out / 'claims.md'}: {agree} of {len(made)} agree")
    if any(each.has_changed and not each.claim.timed for each in made):
        raise typer.Exit(FAILED)
