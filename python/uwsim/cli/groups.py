"""Commands that have commands of their own."""

from __future__ import annotations

import typer


def show_help(context: typer.Context) -> None:
    """Print a group's help if none of its commands is named: the callback of its typer program."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
