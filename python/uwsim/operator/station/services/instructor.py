"""The instructor, who needs a token, changes the trainee's world and can return to saved moments.

While a station has an instructor, the pilot can command only the vehicle. The services of the simulation, which show
and change parameters, are not offered to any client.
"""

from __future__ import annotations

import hmac
import json
import logging
import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from threading import Timer
from typing import Any

from uwsim import _core
from uwsim.base.own_files import mark, require_own
from uwsim.base.texts.value_words import details
from uwsim.bridges.doors.admission import WRONG_MAX_S, WRONG_S
from uwsim.bridges.rare_log import RareLog
from uwsim.channels.guest import Values
from uwsim.exercises.exercise import EVENT_COMMANDS
from uwsim.live import LiveSimulator
from uwsim.operator.station.helm.lease import Lease
from uwsim.operator.station.sessions.running import Moment, Running
from uwsim.operator.station.sessions.sessions import Sessions
from uwsim.scenario.spec.turbidity import visibility_m

LOG = "instructor-log.jsonl"
MOMENTS_MAX = 20
LOG_SHOWN = 50
TIMEOUT_S = 10.0
TEXT_MAX = 200  # letters of a message to the trainee
TOKEN_MIN = 8
REPEAT_S = 1.0  # a member's act is logged once in this time, however often it is repeated
ARGS_MAX = 500  # letters of an act's arguments in the log
LOG_MAX_BYTES = 20_000_000  # of the file, over all sessions in its folder; further acts are shown, but not written
UNLOGGED = ("aim", "aim_camera")  # sent several times a second while a key is held
WRONG_TOKEN = "the instructor's token is wrong"


@dataclass
class Instructor:
    """The instructor of a station. clients: connections that have presented the token.

    folder: where the log is written, with the acts of the trainee and of the instructor. lease: who has the controls.
    """

    token: str
    folder: Path
    lease: Lease
    clients: set[str] = field(default_factory=set)
    log: list[Values] = field(default_factory=list)
    _guessing: set[str] = field(default_factory=set)  # clients whose wrong token is not answered yet
    _rare: RareLog = field(default_factory=lambda: RareLog(logging.getLogger(__name__)))
    _noted: dict[tuple[str, str, bool], tuple[float, Values]] = field(default_factory=dict)  # members' latest acts
    _writer: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1, "uwsim-instructor-log"))

    def __post_init__(self) -> None:
        if len(self.token) < TOKEN_MIN or not self.token.isprintable() or not self.token.isascii():
            raise ValueError(f"instructor token: must have at least {TOKEN_MIN} printable ASCII characters")

    def admit(self, client: str, token: object) -> Future[Values]:
        """Accept a connection, or refuse it: late, so that guessing takes long, and with a line in the log.

        A client whose refusal is due is refused at once, whatever its token; raises ValueError.
        """
        if client in self._guessing:
            raise ValueError(f"{WRONG_TOKEN}, and the answer to it is still due")
        answer: Future[Values] = Future()
        if isinstance(token, str) and hmac.compare_digest(token.encode(), self.token.encode()):
            self.clients.add(client)
            answer.set_result({"success": True, "message": ""})
            return answer
        self._rare.warning("a wrong token was sent for the instructor's place")
        self._guessing.add(client)

        def refuse() -> None:
            self._guessing.discard(client)
            answer.set_result({"success": False, "message": WRONG_TOKEN})

        timer = Timer(min(WRONG_S * len(self._guessing), WRONG_MAX_S), refuse)
        timer.daemon = True
        timer.start()
        return answer

    def require(self, client: str) -> None:
        """Raise ValueError unless a connection has presented the token."""
        if client not in self.clients:
            raise ValueError("for the instructor only")

    def act(self, sessions: Sessions, request: Values) -> str:
        """Execute and log the instructor's request. Return a sentence about the result. Raises ValueError."""
        action, arguments = request.get("action"), request.get("args") or {}
        if not isinstance(action, str) or action not in ACTIONS or not isinstance(arguments, dict):
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(ACTIONS)}")
        running = sessions.present()
        time_s = 1e-9 * running.live.time_ns
        with running.live.privileged():
            outcome = ACTIONS[action](self, sessions, running, arguments)
        if running.judged is not None and action != "command":  # the course itself notes commands
            running.judged.note_instruction(outcome, changed=action == "return_to")
        self._writer.submit(self._write, _entry(time_s, "instructor", action, arguments, outcome)).result()
        return outcome

    def note(self, time_s: float, by: str, act: str, arguments: Values, response: Future[Values] | None = None) -> None:
        """Note a member's act in the log, on a thread of its own, so that no act waits for a disk.

        The file has the first of repeats within REPEAT_S; the log shown has the last. by: the member's name.
        response: its outcome is awaited and noted, so that a refused act does not appear as done.
        """
        if act in UNLOGGED:
            return
        if response is None:
            response = Future()
            response.set_result({"success": True})

        def note(done: Future[Values]) -> None:
            found, name = done.result(), act.replace("_", " ")
            text = name if found["success"] else f"{name}, refused: {found['message']}"
            entry = _entry(time_s, by, act, arguments, text)
            self._writer.submit(self._merge, time.monotonic(), (by, act, found["success"]), entry)

        response.add_done_callback(note)

    def _merge(self, now_s: float, kind: tuple[str, str, bool], entry: Values) -> None:
        self._noted = {each: last for each, last in self._noted.items() if now_s - last[0] < REPEAT_S}
        if kind in self._noted:
            self._noted[kind][1].update({key: entry[key] for key in ("args", "text", "details")})
        else:
            self._noted[kind] = now_s, entry
            self._write(entry)

    def _write(self, entry: Values) -> None:
        """Add an entry to the log. If it cannot be written, warn: the simulation does not depend on it."""
        self.log = [*self.log[1 - LOG_SHOWN :], entry]
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            line = json.dumps(entry) + "\n"
            require_own(path := self.folder / LOG)
            with path.open("a", encoding="utf-8") as file:
                if file.tell() + len(line) > LOG_MAX_BYTES:
                    self._rare.warning(f"the instructor's log is full at {LOG_MAX_BYTES} bytes: acts are not written")
                    return
                file.write(line)
            mark(path)
        except OSError as error:
            self._rare.warning(f"the instructor's log could not be written: {error}")

    def overview(self, running: Running) -> Values:
        """Return the instructor's overview of the simulation, including the truth."""
        seen: Values = running.live.read(_truth).result(TIMEOUT_S)
        exercise = None if running.judged is None else running.judged.state()
        moments = [{"name": moment.name, "time_s": moment.time_s} for moment in running.moments]
        return {**seen, "exercise": exercise, "moments": moments, "log": self.log[::-1]}


def _entry(time_s: float, by: str, action: str, arguments: Values, text: str) -> Values:
    """Return an entry of the log, as wire.training.Instruction."""
    clock = datetime.now().astimezone().isoformat(timespec="seconds")
    given = json.dumps(arguments)
    kept = arguments if len(given) <= ARGS_MAX else {"cut": given[:ARGS_MAX]}
    inner = arguments.get("args")
    said = [each._asdict() for each in details(inner if isinstance(inner, dict) else arguments)]
    return {
        "time_s": round(time_s, 3), "clock": clock, "by": by, "action": action, "args": kept, "text": text,
        "details": said if len(given) <= ARGS_MAX else [],
    }  # fmt: skip


def parameters(live: LiveSimulator) -> Values:
    """Return descriptions_json, with the name, type, unit, bounds, value and so on of each parameter."""
    from dataclasses import asdict

    own = live.simulator.parameters
    waters = {name: _core.WaterOptics.jerlov(name) for name in _core.jerlov_types()}
    return {
        "descriptions_json": json.dumps([asdict(own.describe(name)) for name in own.list("")]),
        "visibility_m": {name: visibility_m(water) for name, water in waters.items()},
    }


def _truth(sim: Any) -> Values:
    vehicles = []
    models = {entry.name: entry.model for entry in sim.scenario.vehicles}
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
                "is_stopped": vehicle.all_stopped,
                "sensors": [each.name for each in vehicle.sensors.values()],
                "thrusters": list(vehicle.thrusters),
                "cameras": list(models[name].cameras),
            }
        )
    faults = {"faults": list(sim.faults.active), "fault_times": _fault_times(sim)}
    return {"time_s": sim.time_s, "vehicles": vehicles, **faults}


def _fault_times(sim: Any) -> list[Values]:
    """Return when each fault began, begins and ended, as far as this is known; see wire.training.FaultTime."""
    found: list[Values] = []
    for event in sim.events:
        if event.name == "fault":
            name = event.values["fault"]
            figures = {key: value for key, value in event.values.items() if key not in ("fault", "kind", "for_s")}
            size = ", ".join(f"{key} {value}" for key, value in figures.items())
            kept = {"name": name, "kind": event.values["kind"], "size": size, "begin_s": event.time_s}
            found.append({**kept, "end_s": None, "planned_end_s": _end_s(event.time_s, event.values.get("for_s"))})
        elif event.name == "fault_ends":
            for each in found:
                if each["name"] == event.values["fault"] and each["end_s"] is None:
                    each["end_s"] = event.time_s
    for name, fault in sim.faults.save()["faults"].items():
        spec = fault["spec"]
        at_s = spec.get("at_s")
        is_pending = fault["count"] == 0 and at_s is not None and fault["begin_tick"] == round(at_s / sim.step_s)
        if is_pending:  # one that was ended before it began never begins
            kept = {"name": name, "kind": spec["kind"], "size": "", "begin_s": at_s}
            found.append({**kept, "end_s": None, "planned_end_s": _end_s(at_s, spec.get("for_s"))})
    return found


def _end_s(begin_s: float, for_s: float | None) -> float | None:
    return None if for_s is None else begin_s + for_s


def _command(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    name, given = arguments.get("name"), arguments.get("args") or {}
    if not isinstance(name, str) or name not in EVENT_COMMANDS or not isinstance(given, dict):
        raise ValueError(f"name = {str(name)[:40]!r}: must be one of {', '.join(EVENT_COMMANDS)}")
    running.live.command(name, **{str(key): value for key, value in given.items()}).result(TIMEOUT_S)
    return str(name).replace("_", " ")


def _pause(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    running.live.pause()
    return "paused"


def _resume(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    if running.judged is not None:
        running.judged.require_begun("resume")
    running.live.resume()
    return "resumed"


def _save_moment(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    if len(running.moments) >= MOMENTS_MAX:
        raise ValueError(f"there are {MOMENTS_MAX} saved moments: forget one first")
    judged = running.judged

    def read(sim: Any) -> Moment:
        course = None if judged is None else judged.course.saved()
        return Moment(f"moment {len(running.moments) + 1}", sim.time_s, sim.save_state(), course)

    moment = running.live.read(read).result(TIMEOUT_S)
    running.moments.append(moment)
    return f"saved {moment.name} at {moment.time_s:.1f} s"


def _return_to(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    found = [moment for moment in running.moments if moment.name == arguments.get("name")]
    if not found:
        raise ValueError(f"name = {str(arguments.get('name'))[:40]!r}: is not a saved moment")
    if running.judged is not None:
        running.judged.course.return_to(found[0].course)
    sessions.rewind(found[0].state)
    sessions.change_pilot()
    return f"returned to {found[0].name}, at {found[0].time_s:.1f} s"


def _restart(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    sessions.rewind()
    return "restarted"


def _message(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    text = arguments.get("text")
    if not isinstance(text, str) or len(text) > TEXT_MAX or not (text == "" or text.isprintable()):
        raise ValueError(f"text: must have at most {TEXT_MAX} printable characters")
    running.instruction = text
    return f"message: {text}" if text else "message taken back"


def _hand_over(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    own.lease.assign(arguments.get("to", ""))
    sessions.change_pilot()
    return f"the controls are given to {own.lease.pilot_name}" if own.lease.pilot else "the controls are free"


def _end(own: Instructor, sessions: Sessions, running: Running, arguments: Values) -> str:
    judged = running.judged
    if judged is None or not judged.course.has_begun or judged.course.is_over:
        raise ValueError("end: no attempt is being flown")
    judged.break_off("ended by the instructor")
    return "ended the attempt"


Action = Callable[[Instructor, Sessions, Running, Values], str]
ACTIONS: dict[str, Action] = {
    "command": _command,
    "pause": _pause,
    "resume": _resume,
    "save_moment": _save_moment,
    "return_to": _return_to,
    "restart": _restart,
    "message": _message,
    "hand_over": _hand_over,
    "end": _end,
}
