"""Recordings: a run's messages and commands in a single file, from which it can be replayed, compared and plotted."""

from __future__ import annotations

from pathlib import Path

from uwsim.recording.commands import Command
from uwsim.recording.reader import Recorded, Recording
from uwsim.recording.recorder import Recorder

__all__ = ["Command", "Recorded", "Recorder", "Recording", "open"]


def open(path: str | Path) -> Recording:  # noqa: A001  # recording.open("run.mcap")
    """Open a recording, even one from a run that was killed. Raises ValueError or OSError."""
    return Recording(path)
