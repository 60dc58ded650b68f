"""Runs a typer program inside a command, for commands that have commands or options of their own."""

from __future__ import annotations

from typing import Any

import typer

PASS_ON: dict[str, Any] = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}
"""Context settings of a command that passes all its arguments, --help among them, to a program of its own."""


def run_typer(program: typer.Typer, arguments: list[str], name: str) -> None:
    """Run a program under a name. Raises what it raises, and typer.Exit for an exit code other than 0."""
    code = program(args=arguments, prog_name=name, standalone_mode=False)
    if code:
        raise typer.Exit(code)
