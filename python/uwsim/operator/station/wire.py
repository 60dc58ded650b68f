"""The fields of the station's requests and answers, as sent and received by its page; `calls` has the services.

docs/connections/station-wire.md explains the fields. The page's functions send no others; the server checks values
where it reads them. Tests hold every answer to these types.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict


class Message(BaseModel):
    """A JSON object with exactly the named fields; one with a default may be missing."""

    model_config = ConfigDict(extra="forbid")


class Nothing(Message):
    """A request without fields."""


# Answers that several services give


class Done(Message):
    """The answer of a service that did what was asked."""

    success: Literal[True]
    message: str


class Refused(Message):
    """The answer of a service that failed. errors: by the field of a choice."""

    success: Literal[False]
    message: str
    errors: dict[str, str] | None = None
    tick: int | None = None
    age_s: float | None = None


class Commanded(Done):
    """A command has taken effect, at a tick, or is sent over a link."""

    tick: int


# The start screen


class Choice(Message):
    """The choice on the start screen; a field that is missing or null keeps the scenario's value."""

    scenario: str | None = None
    vehicle: str | None = None
    sonar: int | str | None = None
    mission_time_s: float | None = None
    seed: int | None = None
    speed: float | None = None
    link: str | None = None
    saved: str | None = None


class ChoiceTaken(Done):
    """A choice is possible, or runs."""

    errors: dict[str, str]


class Offered(Message):
    """A thing to choose by its name."""

    name: str
    description: str


class OfferedVehicle(Message):
    """A vehicle of an offered scenario."""

    name: str
    model: str


class OfferedScenario(Offered):
    """A scenario to choose."""

    seed: int
    mission_time_s: float
    vehicles: list[OfferedVehicle]
    sonar: str | None


class OfferedSonar(Message):
    """A multibeam to choose: a number is one of the paper's models."""

    name: int | str
    title: str
    description: str
    kind: Literal["published", "instrument"]


class Catalog(Message):
    """All that can be chosen. speeds: 0 is as fast as possible. saves: sessions to go on with."""

    scenarios: list[OfferedScenario]
    vehicles: list[Offered]
    sonars: list[OfferedSonar]
    links: list[Offered]
    speeds: list[float]
    defaults: Choice
    saves: list[str]


# What runs


class Tilt(Message):
    """How far and how fast a sonar's head tilts."""

    min_rad: float
    max_rad: float
    rate_rad_s: float


class Multibeam(Message):
    """A multibeam sonar."""

    name: str
    title: str
    range_m: float
    beams: int
    fov_rad: float


class Motor(Message):
    """A camera that turns: its limits."""

    camera: str
    pan_deg: list[float]
    tilt_deg: list[float]


class VehicleDescription(Message):
    """A vehicle: its topics, each null if there is none, and its parts."""

    name: str
    model: str
    prefix: str
    telemetry: str | None
    scan: str | None
    link: str | None
    map: str | None
    map_changes: str | None
    pings_per_s: float
    thrusters: list[str]
    lamps: list[str]
    efforts: list[str]
    tilt: Tilt | None
    sonar: Multibeam | None
    motors: list[Motor]


class ViewLink(Message):
    """How pictures come over a link. period_s: null if there is no room for any."""

    modem: str
    period_s: float | None
    large_only: bool


class ViewDescription(Message):
    """A view: its topics, and the size of its pictures, 0 where they have their own."""

    name: str
    title: str
    kind: Literal["camera", "station", "chase", "forward_looking", "side_scan", "profiling"]
    vehicle: str
    frame_id: str
    width: int
    height: int
    topic: str
    small_topic: str
    link: ViewLink | None = None
    aboard_topic: str | None = None
    aboard_small_topic: str | None = None


class Warnings(Message):
    """Distances of the panel's warnings."""

    range_m: float
    proximity_m: float


class Description(Message):
    """The running simulator."""

    success: Literal[True]
    session: int
    edition: int
    is_fixed: bool
    controls: list[str]
    scenario: str
    description: str
    step_s: float
    mission_time_s: float
    seed: int
    truth_allowed: bool
    warnings: Warnings
    vehicles: list[VehicleDescription]
    views: list[ViewDescription]
    scene: str
    commands: list[str]


# Pilots


class Join(Message):
    """name: shown to the others."""

    name: str | None = None


class Joined(Done):
    """id: this connection's."""

    id: str


class HandOver(Message):
    """to: the id of another member; empty: no one."""

    to: str | None = None


class Drive(Message):
    """Efforts in [-1, 1]; one that is missing is 0. stamp_ms: the page's clock when its keys were read."""

    vehicle: str
    surge: float | None = None
    sway: float | None = None
    heave: float | None = None
    roll: float | None = None
    pitch: float | None = None
    yaw: float | None = None
    stamp_ms: float | None = None


class Driven(Commanded):
    """age_s: by how much the command was late."""

    age_s: float


class AllStop(Message):
    """on: false releases it."""

    vehicle: str
    on: bool | None = None


class Order(Message):
    """name: of a command in the description's list. args: its arguments."""

    name: str
    vehicle: str | None = None
    args: dict[str, Any] | None = None


class SetView(Message):
    """width: 0 for the camera's own."""

    name: str
    rate_hz: float | None = None
    width: float | None = None
    quality: float | None = None


class Control(Message):
    """action: of the description's controls. steps, speed, name: of those that need one."""

    action: str
    steps: float | None = None
    speed: float | None = None
    name: str | None = None
