"""Prints validation checks as a table: expected value, computed value, error and tolerance."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from uwsim.evidence.validate.check import Check

PIPE_WIDTH = 1000
"""Columns where no terminal is: a row is one line, for programs such as grep."""


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
        unit = f" {check.unit}" if check.unit else ""
        table.add_row(
            "" if check.group == previous and target.is_terminal else check.group,
            check.name,
            f"{check.expected:.7g}{unit}",
            f"{check.got:.7g}{unit}",
            f"{check.error:.1e}",
            f"{check.tolerance:.0e}",
            "[green]ok[/]" if check.passed else "[bold red]MISS[/]",
            end_section=False,
        )
        previous = check.group
    target.print(table)
    misses = sum(not check.passed for check in checks)
    target.print(f"{len(checks)} checks, {misses} missed" if misses else f"{len(checks)} checks, all within tolerance")
