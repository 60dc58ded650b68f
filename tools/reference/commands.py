"""The command reference: the output of `uwsim --help` and of each command's --help."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import typer

from uwsim.cli.main import app

HEAD = """# Commands

The output of `uwsim COMMAND --help` for each command.

"""
GROUPS = ("map", "scenario")


def commands_page() -> str:
    """Return the page, with a section for each command."""
    overview = _help()
    program: Any = typer.main.get_command(app)
    names = [
        *program.commands,
        *(f"{group} {name}" for group in GROUPS for name in program.commands[group].commands),
    ]
    with ThreadPoolExecutor() as pool:
        texts = list(pool.map(lambda name: _help(*name.split()), names))
    parts = [f"## uwsim {name}\n\n```text\n{text}\n```\n" for name, text in zip(names, texts, strict=True)]
    return HEAD + f"```text\n{overview}\n```\n\n" + "\n".join(parts)


def _help(*command: str) -> str:
    program = "import sys; from uwsim.cli import main; sys.argv[0] = 'uwsim'; main()"
    done = subprocess.run(
        [sys.executable, "-c", program, *command, "--help"],
        check=True,
        capture_output=True,
        text=True,
        env={"COLUMNS": "110", "PATH": "/usr/bin:/bin", "NO_COLOR": "1"},
    )
    return done.stdout.rstrip()
