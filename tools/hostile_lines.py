"""Attack every command of `uwsim` with hostile values, and report the lines that broke a rule; see tests/hostile.

    tools/hostile                     # all lines, about a quarter of a second of processor time each
    tools/hostile --only map --sample 200
    tools/hostile --files --part 0/2

Do not run it as root, because root can write to folders that must be read-only here. Exits with 1 if a line broke a
rule.
"""

from __future__ import annotations

import os
import random
import shlex
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process with threads must not fork

from hostile.attack import Verdict, attempt, load_factor, preload
from hostile.lines import Line, lines, prepare


def main(
    only: Annotated[str, typer.Option(help="Only commands that begin with this, such as map.")] = "",
    sample: Annotated[int, typer.Option(min=0, help="The number of lines, chosen by the seed; 0: all.")] = 0,
    seed: Annotated[int, typer.Option(help="The seed of the choice.")] = 0,
    part: Annotated[str, typer.Option(help="K/N: the Kth of N parts, from 0, for several processes.")] = "0/1",
    files: Annotated[bool, typer.Option("--files", help="Only the lines that name a hostile file.")] = False,
    each: Annotated[bool, typer.Option("--each", help="Report how every line ended.")] = False,
) -> None:
    """Attack, judge and count."""
    preload(only)
    chosen = [line for line in lines() if line.command.startswith(only)]
    chosen = [line for line in chosen if line.is_about_a_file or not files]
    if sample:
        chosen = random.Random(seed).sample(chosen, min(sample, len(chosen)))
    k, n = map(int, part.split("/"))
    chosen = chosen[k::n]
    codes: Counter[int] = Counter()
    broken: list[Verdict] = []
    began_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="uwsim-hostile-") as folder:
        template = Path(folder) / "template"
        template.mkdir()
        prepare(template)
        for number, line in enumerate(chosen):
            verdict = attempt(line, template, Path(folder) / "run", load_factor())
            codes[verdict.code] += 1
            if verdict.complaint:
                broken.append(verdict)
            if verdict.complaint or each:
                _tell(verdict)
            elif number % 100 == 99:
                typer.echo(f"{number + 1} of {len(chosen)} lines, {time.monotonic() - began_s:.0f} s", err=True)
    by_code = ", ".join(f"{count} with {code}" for code, count in sorted(codes.items()))
    typer.echo(f"{len(chosen)} lines, {len(broken)} broke the law; they ended {by_code}")
    raise typer.Exit(1 if broken else 0)


def _tell(verdict: Verdict) -> None:
    shown = _short(verdict.line)
    ended = f"ended with {verdict.code}" + (f", BROKE THE LAW: {verdict.complaint}" if verdict.complaint else "")
    typer.echo(f"uwsim {shown}\n    {ended} ({verdict.wall_s:.1f} s, {verdict.memory_mb:.0f} MB)")
    for text in verdict.stderr.strip().splitlines()[-3:]:
        typer.echo(f"    | {text[:200]}")


def _short(line: Line) -> str:
    return (
        shlex.join(word if len(word) < 80 else word[:40] + "..." for word in line.words)
        .encode(errors="replace")
        .decode()
    )


if __name__ == "__main__":
    typer.run(main)
