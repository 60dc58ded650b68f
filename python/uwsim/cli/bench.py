"""`uwsim bench`: run one of the benchmarks."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.options import SETTINGS
from uwsim.cli.run_typer import run_typer


def bench(
    context: typer.Context, name: Annotated[str, typer.Argument(help="The benchmark. Default: list all.")] = ""
) -> None:
    """Run a benchmark: medians, and where the time goes.

    `uwsim bench survey --help` lists that benchmark's options.
    """
    folder = _bench_folder()
    known = ", ".join(sorted(path.stem for path in folder.glob("*.py")))
    if name in ("", "--help"):
        typer.echo(f"benchmarks: {known}; uwsim bench NAME --help lists the options of one")
        return
    if name not in known.split(", "):
        raise ValueError(f"benchmark '{name}': unknown; there are: {known}")
    program = typer.Typer(**SETTINGS)
    program.command()(runpy.run_path(str(folder / f"{name}.py"))["main"])
    run_typer(program, context.args, f"uwsim bench {name}")


def _bench_folder() -> Path:
    """Return the folder inside an installed package, or that of the source tree."""
    package = Path(__file__).resolve().parents[1]
    return next(f for f in (package / "bench", package.parents[1] / "tools" / "bench") if f.is_dir())
