"""Handlers of the services that the station's page calls; see `wire.calls`."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.base.commands import COMMANDS, HOLDS
from uwsim.base.commands.command import item
from uwsim.channels.authority.steering import require_link
from uwsim.channels.guest import GuestService, Values
from uwsim.operator.station.controls.lease import Lease
from uwsim.operator.station.controls.pilot import answered, is_stop
from uwsim.operator.station.controls.plan import Plan, PlanFlight, survey_lanes
from uwsim.operator.station.editor.forms import described_forms
from uwsim.operator.station.flights.replay import REFUSAL
from uwsim.operator.station.services.control import CONTROLS, NOT_OF_REPLAYS, OF_EXERCISES, OF_REPLAYS, new_path
from uwsim.operator.station.services.editing import EditService
from uwsim.operator.station.sessions.description import describe
from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.sessions.saves import saved_names
from uwsim.operator.station.sessions.sessions import Sessions
from uwsim.operator.station.start.choice import (
    ChoiceError,
    catalog,
    chosen,
    chosen_exercise,
    chosen_flight,
    chosen_save,
    described,
    described_exercise,
)
from uwsim.operator.station.wire.calls import CALLS
from uwsim.scenario import ScenarioError
from uwsim.simulator.failures.events import comment_of
from uwsim.simulator.helm import Reason

DEAD_S = 3.0  # others may take the controls if a pilot sends nothing for this long, not even replies to pings


class Services:
    """Handles the station's service calls.

    publish: publishes the state. link: the modem that the start screen preselects, if not the scenario's own.
    """

    def __init__(
        self,
        sessions: Sessions,
        lease: Lease,
        publish: Callable[[], object],
        link: str | None,
    ) -> None:
        self._sessions, self._lease, self._publish, self._link = sessions, lease, publish, link
        self._editing = EditService(sessions, lease)

    def all(self) -> list[GuestService]:
        """Return the services that the station offers."""
        return [
            GuestService(
                f"station/{name}",
                call.ros_type,
                _with_errors(getattr(self, f"_{name}")),
                call.description,
                call.is_brief,
                tuple(call.request.model_fields),
            )
            for name, call in CALLS.items()
            if not (call.is_start_screen and self._sessions.is_fixed)
        ]

    def _describe(self, caller: str, request: Values) -> Values:
        running = self._sessions.present()
        own = {"session": self._sessions.number, "edition": running.edition, "is_fixed": self._sessions.is_fixed}
        return {"success": True, **own, "controls": self._controls(), **describe(running)}

    def _controls(self) -> list[str]:
        running = self._sessions.running
        if running is not None and running.judged is not None:
            return [*OF_EXERCISES, *([] if self._sessions.is_fixed else ["quit"])]
        other = OF_REPLAYS if running is None or running.replay is None else NOT_OF_REPLAYS
        closed = (*other, "begin", *(["quit"] if self._sessions.is_fixed else []))
        return [name for name in CONTROLS if name not in closed]

    def _join(self, caller: str, request: Values) -> Values:
        self._lease.join(caller, request.get("name"))
        if caller == self._lease.pilot:
            self._sessions.pass_helm()
        self._publish()
        return {"success": True, "message": "", "id": caller}

    def _take_control(self, caller: str, request: Values) -> Values:
        self._publish()
        if self._lease.pilot != caller:
            is_silent = self._sessions.node.silence_s(self._lease.pilot) > DEAD_S
            self._lease.request(caller, time.monotonic(), is_silent=is_silent)
            self._sessions.change_pilot()
        return {"success": True, "message": ""}

    def _hand_over(self, caller: str, request: Values) -> Values:
        self._lease.hand_over(caller, request.get("to", ""))
        self._sessions.change_pilot()
        self._publish()
        return {"success": True, "message": ""}

    def _drive(self, caller: str, request: Values) -> Values | Future[Values]:
        self._lease.require_pilot(caller)
        running = self._sessions.present()
        if running.plan is not None and running.plan.is_on:
            if not any(request.get(axis) for axis in AXES):  # a released key does not end the plan
                return {"success": True, "message": "a plan is flown", "tick": running.live.tick, "age_s": 0.0}
            running.end_plan(Reason.PILOT)
        return running.pilot.drive(request)

    def _move_arm(self, caller: str, request: Values) -> Future[Values]:
        self._lease.require_pilot(caller)
        running = self._sessions.present()
        _require_open(running, "set_joints")
        if running.replay is not None:
            raise ValueError(REFUSAL)
        return running.pilot.move_arm(request)

    def _all_stop(self, caller: str, request: Values) -> Future[Values]:
        running = self._sessions.present()
        if not is_stop(request):
            self._lease.require_pilot(caller)
        response = running.pilot.all_stop(request, _sent(running))
        if caller != self._lease.pilot and running.judged is not None:
            running.judged.note_stop(self._lease.members.get(caller, "a watcher"), "all stop")
        return response

    def _command(self, caller: str, request: Values) -> Future[Values]:
        self._lease.require_pilot(caller)
        name, vehicle, arguments = request.get("name"), request.get("vehicle"), request.get("args") or {}
        running = self._sessions.present()
        _require_open(running, name)
        if name == "hold" and any(isinstance(arguments, dict) and arguments.get(each) is True for each in HOLDS):
            running.table.rights.require_aid("hold")
        if not isinstance(name, str) or name not in running.commands() or not isinstance(arguments, dict):
            raise ValueError(f"command = {str(name)[:40]!r}: must be one of {', '.join(running.commands())}")
        live, text = running.far, ""
        given = {str(key): value for key, value in arguments.items()}
        if vehicle and "vehicle" in given:
            raise ValueError("args.vehicle: is given beside args")
        if COMMANDS[name].crosses_link:
            require_link(live, vehicle or next(iter(live.simulator.vehicles)), name)
            text = _sent(running)
        future = live.command(name, **({"vehicle": vehicle} if vehicle else {}), **given)
        if COMMANDS[name].steers:
            running.end_plan(Reason.PILOT)
        if name == "hold" and isinstance(vehicle, str):
            running.pilot.note_holds(vehicle, given)
        return answered(live, future, text=text)

    def _plan(self, caller: str, request: Values) -> Values:
        running, action = self._sessions.present(), request.get("action")
        if action == "report":
            return self._planned(running)
        if action == "lanes":
            plan = running.live.read(survey_lanes).result()
            origin_m = running.table.sources[0].origin_m.tolist()
            return {**self._planned(running), "points_m": plan.in_odom(origin_m), "speed_m_s": plan.speed_m_s}
        self._lease.require_pilot(caller)
        if action == "stop":
            running.end_plan("stopped")
            return self._planned(running)
        plan = Plan.of(request, running.table.sources[0].origin_m.tolist())
        if action == "save":
            path = new_path(self._sessions.folder, request, "plan", ".py")
            self._sessions.folder.mkdir(parents=True, exist_ok=True)
            write_atomically(path, plan.file(path.stem, running.live.simulator.scenario.name).encode())
            return {**self._planned(running), "message": f"saved as {path}"}
        if running.replay is not None:
            raise ValueError(REFUSAL)
        if action != "fly":
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of report, lanes, save, fly, stop")
        running.table.rights.require_aid("autopilot")
        if running.judged is not None:
            running.judged.require_begun("plan")
        name = request.get("vehicle")
        item(running.live.vehicles, name, "vehicle")
        if running.carrier is not None:
            raise ValueError("a plan cannot be flown over a link: its control loop runs at the station")
        if running.plan is not None and running.plan.is_on:
            raise ValueError("a plan is flown already: stop it first")
        running.plan = PlanFlight(running.live, str(name), plan)
        return self._planned(running)

    def _planned(self, running: Running) -> Values:
        found = {"is_flying": False, "reached": 0, "ended_because": ""}
        return {"success": True, "message": "", **(found if running.plan is None else running.plan.report())}

    def _exercise(self, caller: str, request: Values) -> Values:
        return {"success": True, **self._sessions.present().flown.state()}

    def _notes(self, caller: str, request: Values) -> Values:
        running, action, message = self._sessions.present(), request.get("action"), ""
        own = running.inspection
        acts = {"list": lambda *_: "", "add": own.add, "comment": own.set_comment}
        if not isinstance(action, str) or action not in acts:
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(acts)}")
        if action != "list":
            self._lease.require_pilot(caller)
            message = acts[action](request)
            self._publish()
        comment = comment_of(running.live.simulator.events)
        return {"success": True, "message": message, "comment": comment, "notes": own.listed()}

    def _set_view(self, caller: str, request: Values) -> Values:
        self._sessions.present().views.set_size(request)
        return {"success": True, "message": ""}

    def _catalog(self, caller: str, request: Values) -> Values:
        found = catalog(self._sessions.offered)
        defaults = found["defaults"] | ({"link": self._link} if self._link else {})
        flights = [] if self._sessions.flights is None else self._sessions.flights.listed()
        editor, offered = self._sessions.editor, [each["name"] for each in found["scenarios"]]
        saved = {name: path for name, path in editor.saved.items() if name not in offered}
        exercises = [*_readable(editor.exercises, described_exercise), *found["exercises"]]
        found = {**found, "scenarios": [*_readable(saved, described), *found["scenarios"]], "exercises": exercises}
        return {**found, "defaults": defaults, "saves": saved_names(self._sessions.folder), "flights": flights}

    def _check(self, caller: str, request: Values) -> Values:
        if request.get("flight") is not None:
            chosen_flight(request)
        elif request.get("exercise_name") is not None:
            chosen_exercise(request, self._sessions.editor.exercises)
        elif request.get("saved") is None:
            scenario, _ = chosen(request, self._sessions.offered, self._sessions.editor.saved)
            if self._sessions.phase == "idle" and caller in self._lease.members:
                self._sessions.prepared.prepare(scenario)
        else:
            chosen_save(request, saved_names(self._sessions.folder))
        return {"success": True, "message": "", "errors": {}}

    def _edit(self, caller: str, request: Values) -> Values:
        return self._editing.answer(caller, request)

    def _edit_forms(self, caller: str, request: Values) -> Values:
        return {"success": True, "sections": described_forms()}

    def _start(self, caller: str, request: Values) -> Values:
        if self._sessions.running is not None:
            self._lease.require_pilot(caller)
        self._sessions.start(request)
        if request.get("rosbridge_host") is None and self._lease.take_if_free(caller):  # else its nodes will drive
            self._sessions.change_pilot()
            self._publish()
        return {"success": True, "message": "", "errors": {}}

    def _control(self, caller: str, request: Values) -> Values:
        self._lease.require_pilot(caller)
        action = request.get("action")
        _require_open(self._sessions.present(), action)
        if action not in self._controls():
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(self._controls())}")
        live = self._sessions.present().live
        said = CONTROLS[action](self._sessions, request)
        self._publish()
        return {"success": True, "message": said or "", "tick": live.tick}


def _require_open(running: Running, act: object) -> None:
    """Raise ValueError if an exercise has closed the world to this act."""
    if isinstance(act, str) and (reason := running.table.rights.refusal_of(act)):
        raise ValueError(reason)


def _readable(saved: dict[str, Path], describe: Callable[[str, Path], Values]) -> list[Values]:
    """Return what files hold, without those that were removed, or changed by hand to hold nothing."""
    found = []
    for name, path in saved.copy().items():
        with suppress(ScenarioError, OSError):
            found.append(describe(name, path))
    return found


def _sent(running: Running) -> str:
    """Return the message for a command sent over the link, or "" if there is no link."""
    return "" if running.carrier is None else f"Sent over {running.carrier.modem}"


def _with_errors(call: Callable[[str, Values], Any]) -> Callable[[str, Values], Any]:
    """Wrap a service so that it reports errors in its response."""

    def answer(caller: str, request: Values) -> Any:
        try:
            return call(caller, request)
        except ChoiceError as error:
            return {"success": False, "message": str(error), "errors": error.errors}
        except (ValueError, RuntimeError, OSError) as error:
            return {"success": False, "message": str(error)}

    return answer
