"""A flight saved in its output folder, ready to be resumed.

    OUT/map.bt                     the map, readable at any time
    OUT/checkpoint/flight.json     the request, the progress, and which files belong to it; replaced last, atomically
    OUT/checkpoint/flight-N.npz    at tick N: the pings; also samples and simulator, if the mission can be saved
    OUT/checkpoint/map-N.ot        the map with its log-odds; also reference-N.ot, if there is a reference map

A mission with `save` and `restore` continues from its saved state. Any other mission is a running Python function,
which cannot be saved: on resuming, it is flown again from its start, without mapping, up to the saved tick. At that
tick, the simulator's state must equal the saved one to the last bit, unless another build saved it. From then on, pings
are added to the saved map. The repetition takes only as long as the physics. Both methods give the same map.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.npz import npz_bytes, read_npz
from uwsim.base.own_files import adopt, is_own, remove_own
from uwsim.base.own_files import is_empty as has_no_content
from uwsim.base.texts.text_file import require_regular
from uwsim.flight.mission_log import LOG
from uwsim.flight.samples import COLUMNS
from uwsim.flight.saved_flight import SavedFlight, read_state
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.scoring.survey_track import TRACK, SurveyTrack

MAP, FOLDER, STATE, EARLIER = "map.bt", "checkpoint", "flight.json", "checkpoint.old"
SIGN = 8  # first columns of the samples, by which a file of them is recognized
LEFTOVER = re.compile(r"\.uwsim-(\d+)-\d+\.tmp|\.([\w-]+\.(json|npz|png|csv)|report\.html|log\.jsonl)\.\w+")


def is_empty(occupancy: OccupancyMap | None) -> bool:
    """Return whether this is a map in which there is nothing yet, for which no earlier one makes way."""
    return occupancy is not None and occupancy.bounds() is None


class FlightCheckpoint:
    """The saved flight in an output folder."""

    def __init__(self, out: Path) -> None:
        self.out, self.folder = out, out / FOLDER

    @property
    def exists(self) -> bool:
        """Whether there is a flight to resume."""
        return (self.folder / STATE).exists()

    def write(self, saved: SavedFlight) -> None:
        """Replace the saved flight, completely or not at all. Raises OSError."""
        maps = {f"map-{saved.tick}.ot": saved.occupancy, f"reference-{saved.tick}.ot": saved.reference}
        arrays_name = f"flight-{saved.tick}.npz"
        files = [*(name for name, occupancy in maps.items() if occupancy is not None), arrays_name]
        if saved.occupancy is not None and not (is_empty(saved.occupancy) and (self.out / MAP).exists()):
            saved.occupancy.write(self.out / MAP)
        try:
            self.folder.mkdir(exist_ok=True)
            for name, occupancy in maps.items():
                if occupancy is not None:
                    occupancy.write(self.folder / name)
            write_atomically(self.folder / arrays_name, npz_bytes(np.savez, **saved.arrays()))
            state = saved.state_file({name: _digest(self.folder / name) for name in files})
            write_atomically(self.folder / STATE, state.sealed())
        except BaseException:
            self._remove_other_files(self._files_of_state())
            raise
        self._remove_other_files(files)

    def read(self) -> SavedFlight:
        """Return the saved flight; raise ValueError if there is none or it is damaged, OSError if it cannot be read."""
        self.require_one()
        path = self.folder / STATE
        try:
            state = read_state(require_regular(path).read_bytes())
        except ValueError as error:
            raise ValueError(f"--resume: '{path}': {error}") from None
        maps, arrays = {}, {}
        engines: dict[str, MapEngine] = {"map": state.request.engine, "reference": "octomap"}
        for name, digest in state.files.items():
            file, kind = self.folder / Path(name).name, name.partition("-")[0]
            if not file.is_file():
                raise ValueError(f"--resume: '{file}': is missing")
            if _digest(file) != digest:
                raise ValueError(f"--resume: '{file}': is damaged: its checksum differs from the one that was saved")
            if file.suffix == ".npz":
                arrays = read_npz(file)
            elif kind in engines:
                maps[kind] = OccupancyMap.read(file, engine=engines[kind])
        if ("map" in maps) != state.request.map or ("reference" in maps) != state.request.verify_map:
            raise ValueError(f"--resume: '{path}': its maps, {sorted(maps)}, are not those of its request")
        self._adopt(state.files)
        try:
            return SavedFlight.of(state, arrays, maps.get("map"), maps.get("reference"))
        except (KeyError, ValueError) as error:
            raise ValueError(f"--resume: '{path}': {error}") from None

    def _adopt(self, files: Collection[str]) -> None:
        """Mark the files of a copied folder, which have no marks, but whose seal and contents are ours."""
        for own in (STATE, *files):
            adopt(self.folder / Path(own).name)
        for name in (MAP, LOG):
            adopt(self.out / name)
        with contextlib.suppress(OSError, ValueError):
            SurveyTrack.read(self.out / TRACK)
            adopt(self.out / TRACK)
        for samples in self.out.glob("track-*.csv"):
            with samples.open("rb") as file:
                if file.readline().startswith(",".join(COLUMNS[:SIGN]).encode()):
                    adopt(samples)

    def require_one(self) -> None:
        """Raise ValueError if there is no flight to resume."""
        if not self.exists:
            ended = (self.out / MAP).exists()
            why = f"its {MAP} belongs to a flight that has ended" if ended else "the folder holds no flight"
            raise ValueError(f"--resume: no unfinished flight is saved in '{self.out}': {why}")

    def remove_leftovers(self) -> None:
        """Remove temporary files left by a flight that was killed while writing."""
        for folder in (self.out, self.folder):
            _remove_leftovers(folder)

    def remove(self) -> None:
        """Remove the saved flight; called when it has ended. Files that are not our own stay."""
        _remove_leftovers(self.folder)
        with contextlib.suppress(OSError):
            remove_own(self.folder)

    def set_aside(self) -> Path | None:
        """Rename a saved flight's folder to make room for another; return the new path, or None if no flight was saved.

        The folder that was set aside before it is removed. Raises OSError if that holds files that are not our own.
        """
        if not self.exists:
            return None
        aside = self.out / EARLIER
        _remove_leftovers(aside)
        if aside.exists() and (left := remove_own(aside)):
            first = left[0].relative_to(self.out)
            raise OSError(f"--out {self.out}: '{first}' is not as uwsim wrote it: remove it first")
        return self.folder.rename(aside)

    def _files_of_state(self) -> Collection[str]:
        """Return the names of the files that belong to the saved state, or none if the state cannot be read."""
        try:
            return read_state(require_regular(self.folder / STATE).read_bytes()).files
        except (OSError, ValueError):
            return ()

    def _remove_other_files(self, keep: Collection[str]) -> None:
        """Remove all maps and arrays except `keep`, and the folder if `keep` is empty."""
        with contextlib.suppress(OSError):
            for path in self.folder.iterdir():
                if path.suffix in (".ot", ".npz") and path.name not in keep and is_own(path):
                    path.unlink()
            if not keep:
                self.folder.rmdir()


def _remove_leftovers(folder: Path) -> None:
    """Remove temporary files of ended processes: those with our mark, and empty ones, which were not marked yet."""
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            found = LEFTOVER.fullmatch(path.name)
            if found and (is_own(path) or has_no_content(path)) and not (found[1] and _is_running(int(found[1]))):
                path.unlink()


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, hashlib.blake2b).hexdigest()
