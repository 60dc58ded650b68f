"""Creates the results folder before a flight begins, since the flight may be long."""

from __future__ import annotations

import tempfile
from pathlib import Path

from uwsim.flight.checkpoint import MAP
from uwsim.flight.results import REPORT, SUMMARY
from uwsim.scoring.survey_track import TRACK


def made_folder(out: Path) -> Path:
    """Create a folder and return it. Raises OSError if it is not writable."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise OSError(f"--out {out}: cannot write there: {error.strerror}") from error
    return out


def results_folder(out: Path) -> Path:
    """Create a flight's results folder and return it. Raises OSError if results could not be written there."""
    made_folder(out)
    for name in (MAP, REPORT, TRACK, SUMMARY):
        if (out / name).exists() and not (out / name).is_file():
            raise OSError(f"--out {out}: '{name}' in it is not a file")
    return out
