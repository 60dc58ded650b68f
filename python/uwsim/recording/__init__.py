"""Recordings: a run's messages and commands in a single file, from which it can be replayed, compared and plotted."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.recording.commands import Command
    from uwsim.recording.messages import Recorded
    from uwsim.recording.reader import Recording
    from uwsim.recording.recorder import Recorder

__all__ = ["Command", "Recorded", "Recorder", "Recording", "open"]
__getattr__ = lazy(
    __name__, {"Command": "commands", "Recorded": "messages", "Recording": "reader", "Recorder": "recorder"}
)


def open(path: str | Path) -> Recording:  # noqa: A001  # recording.open("run.mcap")
    """Open a recording, even one from a run that was killed. Raises ValueError or OSError."""
    from uwsim.recording.reader import Recording

    return Recording(path)
