"""The `uwsim` command."""

from typing import NoReturn

from uwsim.cli.exit_codes import exit_on_signals

__all__ = ["main"]


def main() -> NoReturn:
    """Run the command with the arguments of the process. Returns only by SystemExit."""
    exit_on_signals()
    from uwsim.cli.program import run_program  # takes 60 to 90 ms

    run_program()
