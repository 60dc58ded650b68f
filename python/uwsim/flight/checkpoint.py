"""A flight saved in its output folder, from which it is resumed.

OUT/map.bt                    readable at any time
OUT/checkpoint/flight.json    what was asked for, how far it is, and which files belong to it: replaced last, atomically
OUT/checkpoint/map-N.ot       the map at tick N with its log-odds; path-N.npz: where the sonars pinged

A mission is a running Python function, which cannot be saved. So a resumed mission is flown again from its start,
without the map, as far as it was; there the simulator's state must be what it was to the last bit, unless another
build saved it. From there on the saved map grows. This takes the time of the physics alone, and gives the same map.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from uwsim.atomic_file import write_atomically
from uwsim.flight.map_growth import GrowthRow
from uwsim.flight.mission_file import MissionError
from uwsim.flight.request import FlightRequest
from uwsim.mapping import OccupancyMap
from uwsim.npz import read_npz
from uwsim.scenario.fingerprint import build_fingerprint

MAP, FOLDER, STATE = "map.bt", "checkpoint", "flight.json"
VERSION: Final = 1


class _StateFile(BaseModel):
    """To raise the version makes the flights that users have saved unreadable: give new fields defaults instead."""

    model_config = ConfigDict(extra="forbid")
    version: Literal[1] = VERSION
    build: str = ""
    request: FlightRequest
    tick: Annotated[int, Field(ge=0)]
    state_digest: str
    echo_count: int
    files: dict[str, str]
    growth: tuple[GrowthRow, ...] = ()


@dataclass(frozen=True)
class SavedFlight:
    """A flight to be resumed: it must come by `tick` in the state of state_digest."""

    request: FlightRequest
    tick: int
    state_digest: str
    occupancy: OccupancyMap | None = None
    paths_world_m: dict[str, NDArray[np.float64]] | None = None
    echo_count: int = 0
    growth: tuple[GrowthRow, ...] = ()
    build: str = ""

    def is_state(self, state: bytes) -> bool:
        """Whether it was saved in this state of the simulator; that of another build cannot be compared."""
        return self.build != build_fingerprint() or state_digest(state) == self.state_digest

    def another_flight(self, step_s: float) -> MissionError:
        """Return what is wrong with a flight that does not come by the saved state."""
        at = f"at {self.tick * step_s:g} s it is in another state"
        if self.build != build_fingerprint():
            return MissionError(f"--resume: another build of uwsim saved this flight, and {at}")
        return MissionError(
            f"--resume: the mission does not fly as it did: {at}; "
            "a mission must not depend on random numbers of its own, on files or on the wall clock"
        )


def state_digest(state: bytes) -> str:
    """Return what equal states of a simulator have in common."""
    return hashlib.blake2b(state, digest_size=16).hexdigest()


class FlightCheckpoint:
    """The saved flight in an output folder."""

    def __init__(self, out: Path) -> None:
        self.out, self.folder = out, out / FOLDER

    @property
    def exists(self) -> bool:
        """Whether there is a flight to resume."""
        return (self.folder / STATE).exists()

    def write(self, saved: SavedFlight) -> None:
        """Replace the saved flight, as a whole or not at all. Raises OSError."""
        self.folder.mkdir(parents=True, exist_ok=True)
        files = {}
        if saved.occupancy is not None:
            saved.occupancy.write(self.out / MAP)
            map_name, path_name = f"map-{saved.tick}.ot", f"path-{saved.tick}.npz"
            saved.occupancy.write(self.folder / map_name)
            buffer = io.BytesIO()
            np.savez(buffer, allow_pickle=False, **(saved.paths_world_m or {}))
            write_atomically(self.folder / path_name, buffer.getvalue())
            files = {name: _digest(self.folder / name) for name in (map_name, path_name)}
        state = _StateFile(
            build=build_fingerprint(),
            request=saved.request,
            tick=saved.tick,
            state_digest=saved.state_digest,
            echo_count=saved.echo_count,
            files=files,
            growth=saved.growth,
        )
        write_atomically(self.folder / STATE, state.model_dump_json().encode())
        for path in self.folder.iterdir():
            if path.name not in {STATE, *files}:
                path.unlink(missing_ok=True)

    def require_one(self) -> None:
        """Raise ValueError if there is no flight to resume."""
        if not self.exists:
            raise ValueError(f"--resume: no unfinished flight is saved in '{self.out}'")

    def read(self) -> SavedFlight:
        """Return the saved flight. Raises ValueError if there is none or it is damaged, OSError."""
        self.require_one()
        path = self.folder / STATE
        try:
            state = _StateFile.model_validate(json.loads(path.read_bytes()))
        except json.JSONDecodeError as error:
            raise ValueError(f"--resume: '{path}': is damaged: {error}") from None
        except ValidationError as error:
            first = error.errors()[0]
            if first["loc"] == ("version",):
                rule = f"is of version {first['input']!s:.20}: this uwsim reads {VERSION}"
                raise ValueError(f"--resume: '{path}': {rule}") from None
            where = ".".join(str(part) for part in first["loc"])
            raise ValueError(f"--resume: '{path}': is damaged: {where}: {first['msg']}") from None
        occupancy, paths = None, None
        for name, digest in state.files.items():
            file = self.folder / Path(name).name
            if not file.is_file() or _digest(file) != digest:
                raise ValueError(f"--resume: '{file}': is missing or damaged")
            if file.suffix == ".ot":
                occupancy = OccupancyMap.read(file, engine="bricks")
            else:
                paths = {name: np.asarray(array, np.float64) for name, array in read_npz(file).items()}
        return SavedFlight(
            state.request, state.tick, state.state_digest, occupancy, paths, state.echo_count, state.growth, state.build
        )

    def remove(self) -> None:
        """Remove the saved flight, because it has ended."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, hashlib.blake2b).hexdigest()
