"""Command groups: commands that have subcommands."""

from __future__ import annotations

import typer


def show_help(context: typer.Context) -> None:
    """Print a group's help if no subcommand is given: the callback of its typer program."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
