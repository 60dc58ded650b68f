"""A survey saved in its output folder: the map of the moment for everyone, and what it takes to fly on.

OUT/map.bt                    readable at any time
OUT/checkpoint/survey.state   the flight, and which maps belong to it: replaced last, and at once
OUT/checkpoint/map-N.ot       the map after N pings with all its log-odds; reference-N.ot where there is one
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from uwsim.atomic_file import write_atomically
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.survey.flight_state import FlightState, from_bytes, to_bytes

MAP, FOLDER, STATE, EARLIER = "map.bt", "checkpoint", "survey.state", "checkpoint.old"
LEFTOVER = re.compile(r"\.uwsim-(\d+)-\d+\.tmp|\.(survey\.state|report\.html|[\w-]+\.png)\.\w+")


@dataclass(frozen=True)
class SurveyOrder:
    """What was asked for, resolved: scenario is a packaged one's name or an absolute path."""

    scenario: str
    seed: int
    sonar_model: int | str | None
    sonar_frequency_khz: float | None
    mission_time_s: float | None
    voxel_m: float
    engine: MapEngine
    verify_map: bool

    def new_map(self, memory_limit_mb: float | None = None) -> OccupancyMap:
        """An empty one, as ordered. memory_limit_mb: see OccupancyMap. Raises ValueError."""
        return OccupancyMap(resolution_m=self.voxel_m, engine=self.engine, memory_limit_mb=memory_limit_mb)

    def new_reference(self) -> OccupancyMap | None:
        """Stock OctoMap's, where the map is to be compared with it."""
        return OccupancyMap(resolution_m=self.voxel_m, engine="octomap") if self.verify_map else None

    __pydantic_config__ = ConfigDict(extra="forbid")


@dataclass(frozen=True)
class SavedSurvey:
    """A flight to be resumed, with its maps as they were."""

    order: SurveyOrder
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
        """Whether there is a survey to fly on."""
        return (self.folder / STATE).exists()

    def write(
        self, order: SurveyOrder, state: FlightState, occupancy: OccupancyMap, reference: OccupancyMap | None
    ) -> None:
        """Replace what is saved, all of it or nothing. Raises OSError."""
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
            content = to_bytes(state, {"order": asdict(order), "maps": digests})
            write_atomically(self.folder / STATE, content)
        except BaseException:
            self._tidy()
            raise
        self._tidy(maps)

    def read(self, memory_limit_mb: float | None = None) -> SavedSurvey:
        """memory_limit_mb: of the map.

        Raises ValueError when there is none, or it is damaged; OSError when it cannot be read.
        """
        if not self.exists:
            why = f"{MAP} in it is of a survey that has ended" if (self.out / MAP).exists() else "nothing is in it"
            raise ValueError(f"--resume: no unfinished survey is saved in '{self.out}': {why}")
        path = self.folder / STATE
        try:
            state, more = from_bytes(path.read_bytes())
            order = TypeAdapter(SurveyOrder).validate_python(more.get("order"))
            digests = TypeAdapter(dict[str, str]).validate_python(more.get("maps"))
        except ValidationError as error:
            raise ValueError(f"--resume: '{path}': {error.errors()[0]['msg']}") from None
        except ValueError as error:
            raise ValueError(f"--resume: '{path}': {error}") from None
        engines: dict[str, MapEngine] = {"map": order.engine, "reference": "octomap"}
        maps = {
            kind: self._read_map(name, digest, engines[kind], memory_limit_mb if kind == "map" else None)
            for name, digest in digests.items()
            if (kind := name.split("-")[0]) in engines
        }
        if "map" not in maps or ("reference" in maps) != order.verify_map:
            raise ValueError(f"--resume: '{path}': names {sorted(maps)}: must name its maps")
        return SavedSurvey(order, state, maps["map"], maps.get("reference"))

    def sweep(self) -> None:
        """Remove the temporary files of a survey that was killed while it wrote."""
        for folder in (self.out, self.folder):
            _remove_leftovers(folder)

    def remove(self) -> None:
        """The survey has ended."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def set_aside(self) -> Path | None:
        """Make room for another survey; returns where the one that was there is now, None when there was none.

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
            raise ValueError(f"--resume: '{path}': is damaged: its checksum is not the one that was saved")
        return OccupancyMap.read(path, engine=engine, memory_limit_mb=memory_limit_mb)

    def _tidy(self, keep: Any = None) -> None:
        """Drop maps that belong to no state: all but `keep`, or but those the present state names."""
        if keep is None:
            try:
                keep = from_bytes((self.folder / STATE).read_bytes())[1]["maps"]
            except (OSError, ValueError, KeyError):
                keep = ()
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
            if found and not (found[1] and _runs(int(found[1]))):
                path.unlink()


def _runs(process: int) -> bool:
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
