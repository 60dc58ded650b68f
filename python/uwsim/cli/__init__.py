"""The `uwsim` command."""

from uwsim.cli.main import main

__all__ = ["main"]
