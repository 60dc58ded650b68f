"""Flies a vehicle from the terminal until the pilot quits, and leaves the efforts at zero in all cases."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from uwsim.operator.teleop.app import TeleopApp
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.gamepad import Gamepads
from uwsim.operator.teleop.hands import Hands


class _ToScreen(logging.Handler):
    """Shows warnings on the pilot's screen, since printing them to stderr would corrupt it."""

    def __init__(self, app: TeleopApp) -> None:
        super().__init__(logging.WARNING)
        self._app = app

    def emit(self, record: logging.LogRecord) -> None:
        self._app.report(record.getMessage())


def fly(url: str, name: str, vehicle: str | None = None, *, adds_up: bool = False) -> tuple[list[str], int]:
    """Show the pilot's screen until the pilot quits. Return the marked positions and the exit code.

    adds_up: see Hands. Raises ValueError.
    """
    connection = Connection(url, Hands(adds_up=adds_up), vehicle)
    for each, stream in (("stdin", sys.stdin), ("stderr", sys.stderr)):  # where Textual reads and draws
        if not stream.isatty():
            raise ValueError(
                f"{each} is not a terminal: uwsim teleop needs one; without, see uwsim run and uwsim serve"
            )
    app = TeleopApp(connection, name, Gamepads())
    try:
        with _logging_to(app):
            app.run()
    finally:
        connection.stop()
    return app.marks, app.return_code or 0


@contextmanager
def _logging_to(app: TeleopApp) -> Iterator[None]:
    handler, root = _ToScreen(app), logging.getLogger()
    root.addHandler(handler)
    try:
        yield
    finally:
        root.removeHandler(handler)
