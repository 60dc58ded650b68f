"""The results of a validation: a table for each suite, on the terminal and on a page, and the curves of its checks."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from uwsim.base.atomic_file import write_atomically
from uwsim.evidence.validate.check import Check, Curve, verdict

PIPE_WIDTH = 1000
"""Columns where no terminal is: a row is one line, for programs such as grep."""
PAGE, COLUMNS, MANY = "index.md", 3, 12
HEAD = """# Validation

This page is the output of `uwsim validate --out FOLDER`. It lists every comparison with a closed form, a published
value or a limit. The error is relative to the expected value, or to the scale that the check defines; for a limit it is
the ratio of the computed value to the limit. Laws that the native tests state (`ctest`) are not repeated here.

"""


def row_console() -> Console:
    """Return the console of stdout, on which rows break in a terminal alone."""
    console = Console()
    return console if console.is_terminal else Console(width=PIPE_WIDTH)


def print_checks(checks: list[Check], title: str, console: Console | None = None) -> None:
    """Print the checks as a table, followed by the number of failed checks."""
    target = console or row_console()
    table = Table(title=title, title_justify="left")
    table.add_column("check")
    table.add_column("quantity", overflow="fold")
    for column in ("expected", "computed", "error", "tolerance"):
        table.add_column(column, justify="right")
    table.add_column("")
    previous = ""
    for check in checks:
        group, *cells = check.cells
        shown = "" if group == previous and target.is_terminal else group
        table.add_row(shown, *cells, "[green]ok[/]" if check.passed else "[bold red]MISS[/]", end_section=False)
        previous = group
    target.print(table)
    target.print(verdict(checks))


def write_page(folder: Path, found: dict[str, list[Check]]) -> None:
    """Write index.md into the folder with the curves. found: checks by suite."""
    parts = [_section(suite, checks) for suite, checks in found.items()]
    curves = [f"![{path.stem.replace('_', ' ')}]({path.name})" for path in sorted(folder.glob("*.png"))]
    ending = ["## Curves\n\n" + "\n\n".join(curves) + "\n"] if curves else []
    write_atomically(folder / PAGE, (HEAD + "\n".join([*parts, *ending])).encode())


def _section(suite: str, checks: list[Check]) -> str:
    lines = [f"## {suite}", "", f"{verdict(checks)}.", ""]
    lines += ["| check | quantity | expected | computed | error | tolerance | |", "|---|---|---:|---:|---:|---:|---|"]
    for check in checks:
        cells = (*check.cells, "ok" if check.passed else "**MISS**")
        plain = (cell.replace("|", "\\|").replace("_", "\\_").replace("<", "&lt;") for cell in cells)
        lines.append("| " + " | ".join(plain) + " |")
    return "\n".join(lines) + "\n"


def draw_checks(checks: list[Check], folder: Path, suite: str) -> None:
    """Draw the curves of a suite as one PNG, or, of MANY, as one for each group. Raises OSError."""
    curves: dict[str, list[Curve]] = {}
    for check in checks:
        if check.curve is not None:
            title = check.curve.title or check.name
            curves.setdefault(check.group, []).append(check.curve._replace(title=title))
    if sum(map(len, curves.values())) <= MANY:
        curves = {"": [curve for each in curves.values() for curve in each]}
    for group, each in curves.items():
        if each:
            name = "-".join(filter(None, (suite, re.sub(r"[^A-Za-z0-9_]+", "-", group))))
            draw_curves(each, folder / f"{name}.png", group or suite)


def draw_curves(curves: Sequence[Curve], path: Path, title: str) -> None:
    """Draw curves as a PNG, a panel for each; the first line of each is the expected one. Raises OSError."""
    import matplotlib.pyplot as plt

    from uwsim.figures.style import save_figure

    columns = min(COLUMNS, len(curves))
    rows = -(-len(curves) // columns)
    size = (4.5 * columns, 2.8 * rows) if len(curves) > 1 else (9.0, 5.0)
    figure, panels = plt.subplots(rows, columns, figsize=size, layout="constrained", dpi=120, squeeze=False)
    for panel in panels.flat[len(curves) :]:
        panel.set_axis_off()
    for panel, curve in zip(panels.flat, curves, strict=False):
        for k, (name, values) in enumerate(curve.lines.items()):
            panel.plot(curve.x, values, label=name, **({"lw": 1.2} if k else {"lw": 4, "alpha": 0.35}))
        panel.set_title(curve.title, fontsize=9, wrap=True)
        panel.set(xlabel=curve.across, ylabel=f"[{curve.up}]" if curve.up else "")
        panel.grid(alpha=0.3)
        if curve.x.dtype.kind == "U":
            panel.tick_params("x", rotation=90, labelsize=7)
    figure.legend(*panels.flat[0].get_legend_handles_labels(), fontsize=8, loc="outside upper right", ncols=4)
    figure.suptitle(title)
    save_figure(figure, path)
    plt.close(figure)
