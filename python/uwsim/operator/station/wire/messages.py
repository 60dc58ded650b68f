"""The fields of the station's requests and responses, as exchanged with its page. For the services, see `calls`.

docs/connections/station-wire.md explains the fields. The page sends no other fields. The server checks values where it
reads them. Tests check every response against these types.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict


class Message(BaseModel):
    """A JSON object with exactly these fields. Fields with a default are optional."""

    model_config = ConfigDict(extra="forbid")


class Nothing(Message):
    """A request without fields."""


# Responses shared by several services


class Done(Message):
    """The response of a service that succeeded."""

    success: Literal[True]
    message: str


class Refused(Message):
    """The response of a service that failed. errors: by field of a choice."""

    success: Literal[False]
    message: str
    errors: dict[str, str] | None = None
    tick: int | None = None
    age_s: float | None = None


class Commanded(Done):
    """A command has taken effect at a tick, or has been sent over a link."""

    tick: int


# The running simulator


class Tilt(Message):
    """The range and rate of a sonar head's tilt."""

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
    """A camera with a pan-tilt motor, and its limits."""

    camera: str
    pan_deg: list[float]
    tilt_deg: list[float]


class Proximity(Message):
    """A sensor that looks in one direction, and the topic of its ranges."""

    name: str
    topic: str


class TetherDescription(Message):
    """A tether of a vehicle or loose body. turns: null without upright obstacles. fastest_m_s: null without a winch."""

    shape: str
    tension: str
    turns: str | None
    origin_m: list[float]
    breaking_load_n: float
    fastest_m_s: float | None
    strongest_n: float | None


class SwarmDescription(Message):
    """A school of fish or a plume of bubbles. drawn: how many of it are drawn. colour: albedo, red, green and blue."""

    name: str
    kind: Literal["fish", "bubbles"]
    drawn: int
    size_m: float
    colour: list[float]


class LifeDescription(Message):
    """The topic with the places of all swarms, one after the other, and the swarms."""

    topic: str
    swarms: list[SwarmDescription]


class ArmJoint(Message):
    """A joint of an arm with a motor, and its stops [rad or m]; the page's own where it has none.

    is_jaw: whether it is one of a gripper's.
    """

    name: str
    low: float
    high: float
    is_slide: bool
    is_jaw: bool


class VehicleDescription(Message):
    """A vehicle: its topics, null where there is none, and its parts."""

    name: str
    model: str
    prefix: str
    telemetry: str | None
    sensor_gauges: str | None
    scan: str | None
    joints: str | None
    proximities: list[Proximity]
    link: str | None
    map: str | None
    map_changes: str | None
    pings_per_s: float
    thrusters: list[str]
    lamps: list[str]
    droppers: list[str]
    efforts: list[str]
    holds: list[str]
    tilt: Tilt | None
    sonar: Multibeam | None
    motors: list[Motor]
    tether: TetherDescription | None
    arm: list[ArmJoint]
    can_jog: bool


class ViewLink(Message):
    """The transmission of pictures over a link. period_s: null if there is no capacity for pictures."""

    modem: str
    period_s: float | None
    large_only: bool


class Optics(Message):
    """A camera's mount and lens. follows: `body`, or `heading` from outside. turns: whether it has a motor."""

    yaw_pitch_roll_deg: list[float]
    horizontal_fov_deg: float
    follows: Literal["body", "heading"]
    turns: bool


class SonarPicture(Message):
    """The layout of a sonar picture. shape: `fan`, apex below; `fan_down`, apex above; `waterfall`, newest first.

    fov_rad: the fan's angle; 0 for a waterfall.
    """

    shape: Literal["fan", "fan_down", "waterfall"]
    range_m: float
    fov_rad: float


class ViewDescription(Message):
    """A view, with the size of its pictures, 0 if that varies. kind: `camera`, `station`, `chase` or a sonar's."""

    name: str
    title: str
    kind: str
    vehicle: str
    frame_id: str
    width: int
    height: int
    topic: str
    small_topic: str
    optics: Optics | None = None
    sonar: SonarPicture | None = None
    link: ViewLink | None = None
    aboard_topic: str | None = None
    aboard_small_topic: str | None = None


class Warnings(Message):
    """The panel's warning distances. as_published: whether its lamps are the published simulator's."""

    range_m: float
    proximity_m: float
    as_published: bool


class EventDetail(Message):
    """A value of an event in English words, with its unit."""

    name: str
    text: str


class FlightEvent(Message):
    """An event of a recorded flight. name: of the command or the event. text: all of it in English."""

    time_s: float
    kind: Literal["command", "alarm", "collision"]
    text: str
    name: str
    vehicle: str
    details: list[EventDetail]


class ReplayDescription(Message):
    """The flight being replayed. start_s, end_s: the ends of its time line, in simulated time."""

    flight: str
    start_s: float
    end_s: float
    branched_from: str
    events: list[FlightEvent]


class Description(Message):
    """The running simulator. tethers: those of loose bodies, by name."""

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
    tethers: dict[str, TetherDescription]
    objects: str | None
    life: LifeDescription | None
    commands: list[str]
    has_exercise: bool
    has_survey: bool
    is_recorded: bool
    replay: ReplayDescription | None
    branched_from: str


# Pilots


class Join(Message):
    """A request to join the members. name: shown to the other members."""

    name: str | None = None


class Joined(Done):
    """The response to a Join. id: identifies this connection."""

    id: str


class HandOver(Message):
    """A request to hand over the controls. to: the id of another member; empty releases the controls."""

    to: str | None = None


class Drive(Message):
    """Efforts in [-1, 1], by default 0. stamp_ms: the time on the page's clock at which the keys were read."""

    vehicle: str
    surge: float | None = None
    sway: float | None = None
    heave: float | None = None
    roll: float | None = None
    pitch: float | None = None
    yaw: float | None = None
    stamp_ms: float | None = None


class MoveArm(Message):
    """Shares in [-1, 1] with which an arm moves.

    joints: of their fastest speeds, by name. hand: of 0.1 m/s, ahead, to the left and up in the picture of a camera of
    the vehicle, by default along its own axes. grip: closes the jaws, or opens them. stamp_ms: as of Drive.
    """

    vehicle: str
    joints: dict[str, float] | None = None
    hand: list[float] | None = None
    camera: str | None = None
    grip: float | None = None
    stamp_ms: float | None = None


class Driven(Commanded):
    """The response to a Drive. age_s: the delay of the command."""

    age_s: float


class AllStop(Message):
    """A request to set or release all stop. on: false releases it."""

    vehicle: str
    on: bool | None = None


class Order(Message):
    """A request to issue a command. name: one of the commands listed in the description. args: its arguments."""

    name: str
    vehicle: str | None = None
    args: dict[str, Any] | None = None


class SetView(Message):
    """A request to change a view's pictures. width: 0 for the camera's own width."""

    name: str
    rate_hz: float | None = None
    width: float | None = None
    quality: float | None = None


class Control(Message):
    """A request to control the simulation. action: one of the controls listed in the description.

    steps, speed, name, time_s: for the actions that need them.
    """

    action: str
    steps: float | None = None
    speed: float | None = None
    name: str | None = None
    time_s: float | None = None
