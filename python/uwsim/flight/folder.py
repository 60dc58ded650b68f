"""Creates the results folder before a flight begins, since the flight may be long."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Iterable
from pathlib import Path

from uwsim.base.own_files import is_empty, is_own, remove_own_file, require_own
from uwsim.flight.log import LOG
from uwsim.flight.results import MAP, RESULT_FILES
from uwsim.flight.terminal import Silent

LEFTOVER = re.compile(r"\.uwsim-(\d+)-\d+\.tmp|\.([\w-]+\.(json|npz|png|csv)|report\.html|log\.jsonl)\.\w+")


def made_folder(out: Path, writes: Iterable[str] = (), mode: int = 0o777) -> Path:
    """Create a folder and return it.

    writes: names of the files that will be written there. mode: the folder's permissions if it is created. Raises
    OSError if the folder is not writable, or holds such a file that uwsim did not write.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.mkdir(mode, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise OSError(f"--out {out}: cannot write there: {error.strerror}") from error
    for name in writes:
        if (out / name).exists() and not (out / name).is_file():
            raise OSError(f"--out {out}: '{name}' in it is not a file")
        require_own(out / name)
    return out


def results_folder(out: Path, vehicles: Iterable[str]) -> Path:
    """Create a flight's results folder and return it. Raises OSError if results could not be written there."""
    return made_folder(out, (MAP, LOG, *RESULT_FILES, *(f"track-{vehicle}.csv" for vehicle in vehicles)))


def remove_stale_results(out: Path, names: Iterable[str], screen: Silent) -> None:
    """Remove the results of an earlier flight, which would not match this flight's map."""
    stale = [name for name in names if (out / name).exists()]
    for name in stale:
        remove_own_file(out / name)
    if stale:
        screen.message(f"{out}: removed the results of an earlier flight: {', '.join(stale)}")


def remove_leftovers(folder: Path) -> None:
    """Remove temporary files left by a flight that was killed while writing: marked, or empty and not marked yet."""
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            found = LEFTOVER.fullmatch(path.name)
            if found and (is_own(path) or is_empty(path)) and not (found[1] and _is_running(int(found[1]))):
                path.unlink()


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
