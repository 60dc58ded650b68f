"""The instructor, who needs a token, changes the trainee's world and can return to saved moments.

While a station has an instructor, the pilot can command only the vehicle. The services of the simulation, which show
and change parameters, are not offered to any client.
"""

from __future__ import annotations

import hmac
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.channels.guest import Values
from uwsim.exercises.exercise import EVENT_COMMANDS
from uwsim.live import LiveSimulator

if TYPE_CHECKING:
    from uwsim.operator.station.hub import Station
    from uwsim.operator.station.running import Running

LOG = "instructor-log.jsonl"
MOMENTS_MAX = 20
LOG_SHOWN = 50
TIMEOUT_S = 10.0
TOKEN_MIN = 8


@dataclass
class Moment:
    """A saved moment. course: the state of the exercise, if there is one."""

    name: str
    time_s: float
    state: bytes
    course: object = None


@dataclass
class Instructor:
    """The instructor of a station. clients: connections that have presented the token.

    folder: where the log is written.
    """

    token: str
    folder: Path
    clients: set[str] = field(default_factory=set)
    moments: list[Moment] = field(default_factory=list)
    log: list[Values] = field(default_factory=list)

    def __post_init__(self) -> None:
        if len(self.token) < TOKEN_MIN or not self.token.isprintable() or not self.token.isascii():
            raise ValueError(f"instructor token: must have at least {TOKEN_MIN} printable ASCII characters")

    def admit(self, client: str, token: object) -> None:
        """Accept a connection. Raises ValueError for a wrong token."""
        if not isinstance(token, str) or not hmac.compare_digest(token.encode(), self.token.encode()):
            raise ValueError("the instructor's token is wrong")
        self.clients.add(client)

    def require(self, client: str) -> None:
        """Raise ValueError unless a connection has presented the token."""
        if client not in self.clients:
            raise ValueError("for the instructor only")

    def begin(self) -> None:
        """Forget the moments saved for the previous simulator."""
        self.moments.clear()

    def act(self, station: Station, request: Values) -> str:
        """Execute and log the instructor's request. Return a sentence about the result. Raises ValueError."""
        action, arguments = request.get("action"), request.get("args") or {}
        if not isinstance(action, str) or action not in ACTIONS or not isinstance(arguments, dict):
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(ACTIONS)}")
        running = station.present()
        time_s = 1e-9 * running.live.time_ns
        outcome = ACTIONS[action](self, station, running, arguments)
        self._note(time_s, action, arguments, outcome)
        station.tell()
        return outcome

    def _note(self, time_s: float, action: str, arguments: Values, outcome: str) -> None:
        entry = {"time_s": round(time_s, 3), "action": action, "args": arguments, "text": outcome}
        self.log = [*self.log[1 - LOG_SHOWN :], entry]
        self.folder.mkdir(parents=True, exist_ok=True)
        with (self.folder / LOG).open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")

    def overview(self, running: Running) -> Values:
        """Return the instructor's overview of the simulation, including the truth."""
        seen: Values = running.live.read(_truth).result(TIMEOUT_S)
        exercise = None if running.judged is None else running.judged.state()
        moments = [{"name": moment.name, "time_s": moment.time_s} for moment in self.moments]
        return {**seen, "exercise": exercise, "moments": moments, "log": self.log[::-1]}


def parameters(live: LiveSimulator) -> Values:
    """Return descriptions_json, with the name, type, unit, bounds, value and so on of each parameter."""
    from dataclasses import asdict

    own = live.simulator.parameters
    return {"descriptions_json": json.dumps([asdict(own.describe(name)) for name in own.list("")])}


def _truth(sim: Any) -> Values:
    vehicles = []
    for name, vehicle in sim.vehicles.items():
        panel, pose = vehicle.telemetry(), vehicle.pose
        vehicles.append(
            {
                "name": name,
                "position_world_m": pose.position_world_m.tolist(),
                "heading_deg": (90.0 - math.degrees(pose.yaw_rad)) % 360.0,
                "speed_m_s": panel.speed_m_s,
                "altitude_m": panel.distance_to_seabed_m if math.isfinite(panel.distance_to_seabed_m) else None,
                "battery_percent": panel.battery_percent,
                "collisions": vehicle.collisions,
                "sensors": [each.name for each in vehicle.sensors.values()],
                "thrusters": list(vehicle.thrusters),
            }
        )
    return {"time_s": sim.time_s, "vehicles": vehicles, "faults": list(sim.faults.active)}


def _command(own: Instructor, station: Station, running: Running, arguments: Values) -> str:
    name, given = arguments.get("name"), arguments.get("args") or {}
    if name not in EVENT_COMMANDS or not isinstance(given, dict):
        raise ValueError(f"name = {str(name)[:40]!r}: must be one of {', '.join(EVENT_COMMANDS)}")
    running.live.command(name, **{str(key): value for key, value in given.items()}).result(TIMEOUT_S)
    return str(name).replace("_", " ")


def _pause(own: Instructor, station: Station, running: Running, arguments: Values) -> str:
    running.live.pause()
    return "paused"


def _resume(own: Instructor, station: Station, running: Running, arguments: Values) -> str:
    running.live.resume()
    return "resumed"


def _save_moment(own: Instructor, station: Station, running: Running, arguments: Values) -> str:
    if len(own.moments) >= MOMENTS_MAX:
        raise ValueError(f"there are {MOMENTS_MAX} saved moments: forget one first")
    judged = running.judged

    def read(sim: Any) -> Moment:
        course = None if judged is None else judged.course.saved()
        return Moment(f"moment {len(own.moments) + 1}", sim.time_s, sim.save_state(), course)

    moment = running.live.read(read).result(TIMEOUT_S)
    own.moments.append(moment)
    return f"saved {moment.name} at {moment.time_s:.1f} s"


def _return_to(own: Instructor, station: Station, running: Running, arguments: Values) -> str:
    found = [moment for moment in own.moments if moment.name == arguments.get("name")]
    if not found:
        raise ValueError(f"name = {str(arguments.get('name'))[:40]!r}: is not a saved moment")
    if running.judged is not None:
        running.judged.course.return_to(found[0].course)
    station.rewind(found[0].state)
    station.let_go()
    return f"returned to {found[0].name}, at {found[0].time_s:.1f} s"


def _restart(own: Instructor, station: Station, running: Running, arguments: Values) -> str:
    station.rewind()
    return "restarted"


Action = Callable[[Instructor, "Station", "Running", Values], str]
ACTIONS: dict[str, Action] = {
    "command": _command,
    "pause": _pause,
    "resume": _resume,
    "save_moment": _save_moment,
    "return_to": _return_to,
    "restart": _restart,
}
