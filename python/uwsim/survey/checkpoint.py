"""A survey saved in its output folder: the present map for everyone to read, and what is needed to resume the survey.

OUT/map.bt                    readable at any time
OUT/checkpoint/survey.state   the flight, and which maps belong to it: replaced last, atomically
OUT/checkpoint/map-N.ot       the map after N pings with all its log-odds; reference-N.ot if there is a reference
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
from collections.abc import Collection
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from uwsim.atomic_file import write_atomically
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.survey.flight_state import FlightState, from_bytes, to_bytes
from uwsim.survey.request import SurveyRequest

MAP, FOLDER, STATE, EARLIER = "map.bt", "checkpoint", "survey.state", "checkpoint.old"
LEFTOVER = re.compile(
    r"\.uwsim-(\d+)-\d+\.tmp|\.(survey\.state|report\.html|summary\.json|track\.npz|[\w-]+\.png)\.\w+"
)


@dataclass(frozen=True)
class SavedSurvey:
    """A survey to be resumed, with its maps as they were when it was saved."""

    request: SurveyRequest
    state: FlightState
    occupancy: OccupancyMap
    reference: OccupancyMap | None


class Checkpoint:
    """The saved survey in an output folder."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.folder = out / FOLDER

    @property
    def exists(self) -> bool:
        """Whether there is a survey to resume."""
        return (self.folder / STATE).exists()

    def write(
        self, request: SurveyRequest, state: FlightState, occupancy: OccupancyMap, reference: OccupancyMap | None
    ) -> None:
        """Replace the saved survey, as a whole or not at all. Raises OSError."""
        occupancy.write(self.out / MAP)
        count = len(state.log.positions_world_m)
        maps = {f"map-{count}.ot": occupancy}
        if reference is not None:
            maps[f"reference-{count}.ot"] = reference
        try:
            self.folder.mkdir(exist_ok=True)
            for name, each in maps.items():
                each.write(self.folder / name)
            digests = {name: _digest(self.folder / name) for name in maps}
            content = to_bytes(state, {"order": asdict(request), "maps": digests})
            write_atomically(self.folder / STATE, content)
        except BaseException:
            self._remove_other_maps(self._maps_of_state())
            raise
        self._remove_other_maps(maps)

    def read(self, memory_limit_mb: float | None = None) -> SavedSurvey:
        """Return the saved survey. memory_limit_mb: limit of its map's memory.

        Raises ValueError when there is none or it is damaged, OSError when it cannot be read.
        """
        self.require_one()
        path = self.folder / STATE
        try:
            state, more = from_bytes(path.read_bytes())
            request = TypeAdapter(SurveyRequest).validate_python(more.get("order"))
            digests = TypeAdapter(dict[str, str]).validate_python(more.get("maps"))
        except ValidationError as error:
            raise ValueError(f"--resume: '{path}': {error.errors()[0]['msg']}") from None
        except ValueError as error:
            raise ValueError(f"--resume: '{path}': {error}") from None
        engines: dict[str, MapEngine] = {"map": request.engine, "reference": "octomap"}
        maps = {
            kind: self._read_map(name, digest, engines[kind], memory_limit_mb if kind == "map" else None)
            for name, digest in digests.items()
            if (kind := name.split("-")[0]) in engines
        }
        if "map" not in maps or ("reference" in maps) != request.verify_map:
            expected = "map and reference" if request.verify_map else "map"
            raise ValueError(f"--resume: '{path}': maps = {sorted(maps)}: expected {expected}")
        return SavedSurvey(request, state, maps["map"], maps.get("reference"))

    def require_one(self) -> None:
        """Raise ValueError when there is no survey to resume."""
        if not self.exists:
            ended = (self.out / MAP).exists()
            why = f"its {MAP} belongs to a survey that has ended" if ended else "the folder holds no survey"
            raise ValueError(f"--resume: no unfinished survey is saved in '{self.out}': {why}")

    def remove_leftovers(self) -> None:
        """Remove the temporary files of a survey that was killed while it wrote."""
        for folder in (self.out, self.folder):
            _remove_leftovers(folder)

    def remove(self) -> None:
        """Remove the saved survey, because it has ended."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def set_aside(self) -> Path | None:
        """Rename the saved survey to make room for another; returns its new path, None when there was none.

        Raises OSError.
        """
        if not self.exists:
            return None
        aside = self.out / EARLIER
        shutil.rmtree(aside, ignore_errors=True)
        return self.folder.rename(aside)

    def _read_map(self, name: str, digest: str, engine: MapEngine, memory_limit_mb: float | None) -> OccupancyMap:
        path = self.folder / Path(name).name
        if not path.exists():
            raise ValueError(f"--resume: '{path}': is missing")
        if _digest(path) != digest:
            raise ValueError(f"--resume: '{path}': is damaged: its checksum differs from the one that was saved")
        return OccupancyMap.read(path, engine=engine, memory_limit_mb=memory_limit_mb)

    def _maps_of_state(self) -> Collection[str]:
        """Return the names of the maps that belong to the present state; none if it cannot be read."""
        try:
            maps: dict[str, str] = from_bytes((self.folder / STATE).read_bytes())[1]["maps"]
        except (OSError, ValueError, KeyError):
            return ()
        return maps

    def _remove_other_maps(self, keep: Collection[str]) -> None:
        """Remove maps that belong to no state, and the folder if nothing is kept."""
        with contextlib.suppress(OSError):
            for path in self.folder.glob("*.ot"):
                if path.name not in keep:
                    path.unlink()
            if not keep:
                self.folder.rmdir()


def _remove_leftovers(folder: Path) -> None:
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            found = LEFTOVER.fullmatch(path.name)
            if found and not (found[1] and _is_running(int(found[1]))):
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
