"""The output folder of a flight."""

from __future__ import annotations

import tempfile
from pathlib import Path


def made_folder(out: Path) -> Path:
    """Make the output folder. Raises OSError, before a long flight, if nothing could be written there."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise OSError(f"--out {out}: cannot write there: {error.strerror}") from error
    return out
