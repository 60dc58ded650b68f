"""Handlers of the services that the station's page calls; see `calls`."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.base.commands import COMMANDS
from uwsim.channels.guest import GuestService, Values
from uwsim.channels.steering import require_link
from uwsim.operator.station.calls import CALLS
from uwsim.operator.station.choice import ChoiceError, catalog, chosen, chosen_flight, chosen_save
from uwsim.operator.station.control import CONTROLS, NOT_OF_REPLAYS, OF_REPLAYS, new_path
from uwsim.operator.station.helm import answered, is_stop
from uwsim.operator.station.instructor import Instructor, parameters
from uwsim.operator.station.plan import Plan, PlanFlight
from uwsim.operator.station.running import Running
from uwsim.operator.station.saves import saved_names
from uwsim.simulator.notes import comment_of

if TYPE_CHECKING:
    from uwsim.operator.station.hub import Station

SUPERVISED = ("record", "stop_recording")  # controls of a pilot who has an instructor
DEAD_S = 3.0  # others may take the controls if a pilot sends nothing for this long, not even replies to pings


class Services:
    """Handles the station's service calls."""

    def __init__(self, station: Station) -> None:
        self._station = station

    def all(self) -> list[GuestService]:
        """Return the services that the station offers."""
        return [
            GuestService(
                f"station/{name}",
                call.ros_type,
                _with_errors(getattr(self, f"_{name}")),
                call.description,
                call.is_brief,
            )
            for name, call in CALLS.items()
            if not (call.is_start_screen and self._station.is_fixed)
        ]

    def _describe(self, caller: str, request: Values) -> Values:
        running = self._station.present()
        said = {"session": self._station.session, "edition": running.edition, "is_fixed": self._station.is_fixed}
        return {"success": True, **said, "controls": self._controls(), **running.describe()}

    def _controls(self) -> list[str]:
        if self._station.instructor is not None:
            return list(SUPERVISED)
        running = self._station.running
        other = OF_REPLAYS if running is None or running.replay is None else NOT_OF_REPLAYS
        return [name for name in CONTROLS if name not in other and not (self._station.is_fixed and name == "quit")]

    def _join(self, caller: str, request: Values) -> Values:
        self._station.lease.join(caller, request.get("name"))
        self._station.tell()
        return {"success": True, "message": "", "id": caller}

    def _take_control(self, caller: str, request: Values) -> Values:
        self._station.tell()
        if self._station.lease.pilot != caller:
            is_silent = self._station.node.silence_s(self._station.lease.pilot) > DEAD_S
            self._station.lease.take(caller, time.monotonic(), is_silent=is_silent)
            self._station.let_go()
        return {"success": True, "message": ""}

    def _hand_over(self, caller: str, request: Values) -> Values:
        self._station.lease.hand_over(caller, request.get("to", ""))
        self._station.let_go()
        self._station.tell()
        return {"success": True, "message": ""}

    def _drive(self, caller: str, request: Values) -> Values | Future[Values]:
        self._station.lease.require_pilot(caller)
        running = self._station.present()
        if running.plan is not None and running.plan.is_on:
            if not any(request.get(axis) for axis in AXES):  # a released key does not end the plan
                return {"success": True, "message": "a plan is flown", "tick": running.live.tick, "age_s": 0.0}
            running.end_plan("the pilot has taken over")
        return running.helm.drive(request)

    def _all_stop(self, caller: str, request: Values) -> Future[Values]:
        if not is_stop(request):
            self._station.lease.require_pilot(caller)
        running = self._station.present()
        return running.helm.all_stop(request, _sent(running))

    def _command(self, caller: str, request: Values) -> Future[Values]:
        self._station.lease.require_pilot(caller)
        name, vehicle, arguments = request.get("name"), request.get("vehicle"), request.get("args") or {}
        running = self._station.present()
        if not isinstance(name, str) or name not in running.commands() or not isinstance(arguments, dict):
            raise ValueError(f"command = {str(name)[:40]!r}: must be one of {', '.join(running.commands())}")
        live, text = running.far, ""
        given = {str(key): value for key, value in arguments.items()}
        if COMMANDS[name].crosses_link:
            require_link(live, vehicle or next(iter(live.simulator.vehicles)), name)
            text = _sent(running)
        future = live.command(name, **({"vehicle": vehicle} if vehicle else {}), **given)
        if COMMANDS[name].steers:
            running.end_plan("the pilot has taken over")
        if name == "hold" and isinstance(vehicle, str):
            running.helm.note_holds(vehicle, given)
        return answered(live, future, text=text)

    def _plan(self, caller: str, request: Values) -> Values:
        running, action = self._station.present(), request.get("action")
        if action == "report":
            return self._planned(running)
        self._station.lease.require_pilot(caller)
        if action == "stop":
            running.end_plan("stopped")
            return self._planned(running)
        plan = Plan.of(request, running.table.sources[0].origin_m.tolist())
        if action == "save":
            path = new_path(self._station, request, "plan", ".py")
            self._station.folder.mkdir(parents=True, exist_ok=True)
            write_atomically(path, plan.file(path.stem, running.live.simulator.scenario.name).encode())
            return {**self._planned(running), "message": f"saved as {path}"}
        if running.replay is not None:
            raise ValueError(running.live.refusal)
        if action != "fly":
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of report, save, fly, stop")
        name = request.get("vehicle")
        if name not in running.live.vehicles:
            raise ValueError(f"vehicle = {str(name)[:40]!r}: must be one of {', '.join(running.live.vehicles)}")
        if running.carrier is not None:
            raise ValueError("a plan cannot be flown over a link: its control loop runs at the station")
        if running.plan is not None and running.plan.is_on:
            raise ValueError("a plan is flown already: stop it first")
        running.plan = PlanFlight(running.live, str(name), plan)
        return self._planned(running)

    def _planned(self, running: Running) -> Values:
        found = {"is_flying": False, "reached": 0, "ended_because": ""}
        return {"success": True, "message": "", **(found if running.plan is None else running.plan.report())}

    def _instructor(self) -> Instructor:
        if self._station.instructor is None:
            raise ValueError("this station has no instructor")
        return self._station.instructor

    def _supervise(self, caller: str, request: Values) -> Values:
        self._instructor().admit(caller, request.get("token"))
        return {"success": True, "message": ""}

    def _instruct(self, caller: str, request: Values) -> Values:
        own = self._instructor()
        own.require(caller)
        return {"success": True, "message": own.act(self._station, request), "tick": self._station.present().live.tick}

    def _overview(self, caller: str, request: Values) -> Values:
        own = self._instructor()
        own.require(caller)
        return {"success": True, **own.overview(self._station.present())}

    def _parameters(self, caller: str, request: Values) -> Values:
        self._instructor().require(caller)
        return {"success": True, **parameters(self._station.present().live)}

    def _exercise(self, caller: str, request: Values) -> Values:
        judged = self._station.present().judged
        if judged is None:
            raise ValueError("no exercise is flown")
        return {"success": True, **judged.state()}

    def _notes(self, caller: str, request: Values) -> Values:
        running, action, message = self._station.present(), request.get("action"), ""
        own = running.inspection
        acts = {"list": lambda *_: "", "add": own.add, "comment": own.set_comment}
        if not isinstance(action, str) or action not in acts:
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(acts)}")
        if action != "list":
            self._station.lease.require_pilot(caller)
            message = acts[action](running, request)
            self._station.tell()
        comment = comment_of(running.live.simulator.events)
        return {"success": True, "message": message, "comment": comment, "notes": own.listed(running)}

    def _set_view(self, caller: str, request: Values) -> Values:
        self._station.present().views.set_size(request)
        return {"success": True, "message": ""}

    def _catalog(self, caller: str, request: Values) -> Values:
        found = catalog(self._station.offered)
        defaults = found["defaults"] | ({"link": self._station.link} if self._station.link else {})
        flights = [] if self._station.flights is None else self._station.flights.listed()
        return {**found, "defaults": defaults, "saves": saved_names(self._station.folder), "flights": flights}

    def _check(self, caller: str, request: Values) -> Values:
        if request.get("flight") is not None:
            chosen_flight(request)
        elif request.get("saved") is None:
            scenario, _ = chosen(request, self._station.offered)
            if self._station.phase == "idle" and caller in self._station.lease.members:
                self._station.prepared.want(scenario)
        else:
            chosen_save(request, saved_names(self._station.folder))
        return {"success": True, "message": "", "errors": {}}

    def _start(self, caller: str, request: Values) -> Values:
        if self._station.running is not None:
            self._station.lease.require_pilot(caller)
        self._station.start(request)
        return {"success": True, "message": "", "errors": {}}

    def _control(self, caller: str, request: Values) -> Values:
        self._station.lease.require_pilot(caller)
        action = request.get("action")
        if action not in self._controls():
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(self._controls())}")
        live = self._station.present().live
        said = CONTROLS[action](self._station, request)
        self._station.tell()
        return {"success": True, "message": said or "", "tick": live.tick}


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
