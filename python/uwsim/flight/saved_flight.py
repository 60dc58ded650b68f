"""A saved flight as data: its JSON, its arrays, and the checks on a flight that continues it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from uwsim.base.texts.json_text import json_value
from uwsim.flight.map_growth import GrowthRow
from uwsim.flight.mission_file import MissionError
from uwsim.flight.pinging import SavedPinging
from uwsim.flight.request import FlightRequest
from uwsim.mapping import OccupancyMap
from uwsim.missions.own_vehicle import Event
from uwsim.scenario.fingerprint import build_fingerprint

VERSION: Final = 2
Tick = Annotated[int, Field(ge=0)]


class SavedMission(BaseModel):
    """The state from which a mission with `save` continues, apart from the simulator's state and the samples.

    state: the mission's own state. clock: see FlightClock.phase. begun_tick: tick at which the flight began. events:
    the log so far. attachments: what each returned from `save`, by name.
    """

    model_config = ConfigDict(extra="forbid")
    state: dict[str, Any]
    clock: tuple[Tick, float]
    begun_tick: Tick
    events: list[Event] = Field(default_factory=list)
    attachments: dict[str, dict[str, Any]] = Field(default_factory=dict)


class StateFile(BaseModel):
    """The content of flight.json. due: see SavedPinging. files: checksums by file name.

    Raising the version makes users' saved flights unreadable: give new fields defaults instead.
    """

    model_config = ConfigDict(extra="forbid")
    version: Literal[2] = VERSION
    checksum: str = ""
    build: str = ""
    request: FlightRequest
    tick: Tick
    state_digest: str
    files: dict[str, str]
    growth: tuple[GrowthRow, ...] = ()
    due: dict[str, tuple[Tick, Annotated[int, Field(ge=1)]]] = Field(default_factory=dict)
    wall_s: Annotated[float, Field(ge=0)] = 0.0
    stage_wall_s: dict[str, float] = Field(default_factory=dict)
    mission: SavedMission | None = None

    def sealed(self) -> bytes:
        """Return the file's bytes, including a checksum of the other fields."""
        content = self.model_dump(mode="json")
        return json.dumps({**content, "checksum": checksum_of(content)}).encode()


def checksum_of(content: Mapping[str, Any]) -> str:
    """Return a checksum of all fields in a file except the checksum itself."""
    fields = {name: value for name, value in content.items() if name != "checksum"}
    return hashlib.blake2b(json.dumps(fields, sort_keys=True).encode(), digest_size=16).hexdigest()


def read_state(data: bytes) -> StateFile:
    """Parse a state file. Raises ValueError if it is damaged or of another version."""
    try:
        content = json_value(data, "the file")
        state = StateFile.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        if first["loc"] == ("version",):
            raise ValueError(f"has version {first['input']!s:.20}: this uwsim reads {VERSION}") from None
        raise ValueError(f"is damaged: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    except ValueError as error:
        raise ValueError(f"is damaged: {error}") from None
    if state.checksum != checksum_of(content):
        raise ValueError("is damaged: its checksum does not match its content")
    return state


@dataclass(frozen=True)
class SavedFlight:
    """A flight to be resumed.

    tick: the tick at which it was saved. state_digest: digest of the simulator's state at that tick. build: fingerprint
    of the build that saved it. wall_s: wall time used so far. pinging: None without a map. mission: None if the mission
    must be flown again up to `tick`; otherwise `simulation` contains the bytes of Simulator.save_state, and `samples`
    the rows by vehicle.
    """

    request: FlightRequest
    tick: int
    state_digest: str
    build: str = ""
    wall_s: float = 0.0
    stage_wall_s: Mapping[str, float] = field(default_factory=dict)
    occupancy: OccupancyMap | None = None
    reference: OccupancyMap | None = None
    pinging: SavedPinging | None = None
    mission: SavedMission | None = None
    simulation: bytes = b""
    samples: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def state_file(self, files: dict[str, str]) -> StateFile:
        """Return the content of flight.json. files: checksums of the other files, by name."""
        pinging = self.pinging
        return StateFile(
            build=build_fingerprint(), request=self.request, tick=self.tick, state_digest=self.state_digest,
            files=files, growth=() if pinging is None else pinging.growth,
            due={} if pinging is None else dict(pinging.due),
            wall_s=self.wall_s, stage_wall_s=dict(self.stage_wall_s), mission=self.mission,
        )  # fmt: skip

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of flight-N.npz, named `pings:VEHICLE:NAME`, `samples:VEHICLE` and `simulation`."""
        logs = {} if self.pinging is None else self.pinging.logs
        pings = {f"pings:{vehicle}:{name}": array for vehicle, log in logs.items() for name, array in log.items()}
        samples = {f"samples:{vehicle}": rows for vehicle, rows in self.samples.items()}
        simulation = {} if self.mission is None else {"simulation": np.frombuffer(self.simulation, np.uint8)}
        return {**pings, **samples, **simulation}

    @classmethod
    def of(
        cls, state: StateFile, arrays: Mapping[str, NDArray[Any]], occupancy: OccupancyMap | None,
        reference: OccupancyMap | None,
    ) -> SavedFlight:  # fmt: skip
        """Build a saved flight from its state file, arrays and maps. Raises KeyError if an array is missing."""
        logs: dict[str, dict[str, NDArray[Any]]] = {}
        for key, array in arrays.items():
            if key.startswith("pings:"):
                _, vehicle, name = key.split(":", 2)
                logs.setdefault(vehicle, {})[name] = array
        pinging = None if occupancy is None else SavedPinging(state.tick, logs, state.due, state.growth)
        return cls(
            request=state.request, tick=state.tick, state_digest=state.state_digest, build=state.build,
            wall_s=state.wall_s, stage_wall_s=state.stage_wall_s, occupancy=occupancy, reference=reference,
            pinging=pinging, mission=state.mission,
            simulation=b"" if state.mission is None else arrays["simulation"].tobytes(),
            samples={k.partition(":")[2]: rows for k, rows in arrays.items() if k.startswith("samples:")},
        )  # fmt: skip

    def with_growth(self, growth: tuple[GrowthRow, ...]) -> SavedFlight:
        """Return a copy with these map-growth measurements."""
        return self if self.pinging is None else replace(self, pinging=replace(self.pinging, growth=growth))

    def is_state(self, state: bytes) -> bool:
        """Return whether the flight was saved in this simulator state; True if another build saved it."""
        return self.build != build_fingerprint() or state_digest(state) == self.state_digest

    def another_flight(self, step_s: float) -> MissionError:
        """Return the error to raise if the repeated flight does not reproduce the saved state."""
        at = f"at {self.tick * step_s:g} s it is in another state"
        if self.build != build_fingerprint():
            return MissionError(f"--resume: another build of uwsim saved this flight, and {at}")
        return MissionError(
            f"--resume: the mission does not fly as it did: {at}; "
            "a mission must not depend on random numbers of its own, on files or on the wall clock"
        )


def state_digest(state: bytes) -> str:
    """Return a digest of a simulator's state."""
    return hashlib.blake2b(state, digest_size=16).hexdigest()
