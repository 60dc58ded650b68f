"""Requests and responses of the station's services for its start screen; see `messages`."""

from __future__ import annotations

from typing import Literal

from uwsim.operator.station.wire.messages import Done, Message


class Choice(Message):
    """The choice on the start screen. A missing or null field keeps the scenario's value.

    tilt_deg: of the sonar's head, down. rosbridge_*: the user's server.
    """

    scenario: str | None = None
    vehicle: str | None = None
    sonar: int | str | None = None
    tilt_deg: float | None = None
    mission_time_s: float | None = None
    seed: int | None = None
    speed: float | None = None
    link: str | None = None
    rosbridge_host: str | None = None
    rosbridge_port: int | None = None
    rosbridge_ros: int | None = None
    saved: str | None = None
    flight: str | None = None
    exercise_name: str | None = None


class ChoiceTaken(Done):
    """The response to a choice that is valid or has been started."""

    errors: dict[str, str]


class Offered(Message):
    """An item that can be chosen by name."""

    name: str
    description: str


class OfferedVehicle(Message):
    """A vehicle of an offered scenario."""

    name: str
    model: str


class OfferedScenario(Offered):
    """A scenario that can be chosen."""

    group: Literal["own", "lakes", "sea", "structures", "basins"]
    has_survey: bool
    seed: int
    mission_time_s: float
    vehicles: list[OfferedVehicle]
    sonar: str | None
    tilt_deg: float | None


class OfferedSonar(Message):
    """A multibeam that can be chosen. A number refers to one of the paper's models."""

    name: int | str
    title: str
    description: str
    kind: Literal["published", "instrument"]


class OfferedExercise(Message):
    """A packaged exercise."""

    name: str
    title: str
    brief: str
    scenario: str
    time_s: float
    points: float
    pass_points: float


class RecordedFlight(Message):
    """A recorded flight. begun: wall-clock time, ISO 8601. refused: why the flight cannot be replayed, or empty.

    exercise: the title of the one that was flown, or empty. from_log: the file of a real flight from which it was made,
    or empty. cut_off: whether its recording ends early, after duration_s, because the station was killed or the disk
    was full.
    """

    name: str
    scenario: str
    begun: str
    duration_s: float
    cut_off: bool
    size_bytes: int
    branched_from: str
    exercise: str
    from_log: str
    refused: str


class Catalog(Message):
    """All available choices. speeds: 0 is as fast as possible. saves: sessions that can be continued.

    flights: newest first. exercises: in the order of the course.
    """

    scenarios: list[OfferedScenario]
    vehicles: list[Offered]
    sonars: list[OfferedSonar]
    exercises: list[OfferedExercise]
    tilts_deg: list[float]
    links: list[Offered]
    speeds: list[float]
    defaults: Choice
    saves: list[str]
    flights: list[RecordedFlight]
