"""The command reference: the output of `uwsim --help` and of each command's --help."""

import contextlib
import io
import os
from typing import Any
from unittest import mock

import typer

from uwsim.cli.groups import WithDefault
from uwsim.cli.program import app

HEAD = """# Commands

The output of `uwsim COMMAND --help` for each command.

"""


def commands_page() -> str:
    """Return the page, with a section for each command."""
    program: Any = typer.main.get_command(app)
    names = [name for group, each in program.commands.items() for name in (group, *_subcommands(group, each))]
    parts = [f"## uwsim {name}\n\n```text\n{_help(program, *name.split())}\n```\n" for name in names]
    return HEAD + f"```text\n{_help(program)}\n```\n\n" + "\n".join(parts)


def _subcommands(name: str, command: Any) -> list[str]:
    """Return the spellings of a group's subcommands, without that of its default."""
    return [f"{name} {each}" for each in getattr(command, "commands", ())][isinstance(command, WithDefault) :]


def _help(program: Any, *command: str) -> str:
    text = io.StringIO()
    with mock.patch.dict(os.environ, {"COLUMNS": "110", "NO_COLOR": "1"}), contextlib.redirect_stdout(text):
        program.main([*command, "--help"], prog_name="uwsim", standalone_mode=False)
    return text.getvalue().rstrip()
