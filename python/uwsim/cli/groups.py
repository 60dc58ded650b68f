"""Groups of commands: the headings of `uwsim --help`, and commands with subcommands."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperGroup


class CommandsByHeading(TyperGroup):
    """A program whose --help lists each command under a heading, the command's `rich_help_panel`.

    Typer shows these headings only in its markup mode, which would swallow units in brackets.
    """

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands by heading, all aligned in the same columns."""
        shown = {name: command for name, command in self.commands.items() if not command.hidden}
        width = max(map(len, shown))
        for heading in dict.fromkeys(_heading(command) for command in shown.values()):
            rows = [
                (name.ljust(width), command.get_short_help_str(formatter.width - width - 6))
                for name, command in shown.items()
                if _heading(command) == heading
            ]
            with formatter.section(heading):
                formatter.write_dl(rows)


def _heading(command: Any) -> str:
    return command.rich_help_panel or "Commands"


def show_help(context: typer.Context) -> None:
    """Print a group's help if it is called without a subcommand; the callback of its typer program."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
