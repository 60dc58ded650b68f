"""The station's end of the graph: it starts and ends simulators, knows the pilot, and answers what the page asks."""

from __future__ import annotations

import itertools
import logging
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Self

from uwsim.channels import Channel, Service
from uwsim.channels.build import message
from uwsim.channels.guest import GuestService, GuestTopic, Node, Values
from uwsim.channels.own_types import STATION_STATE
from uwsim.channels.table import Wire
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.scenario import ScenarioError
from uwsim.simulator import Simulator
from uwsim.station.choice import ChoiceError, catalog, chosen, chosen_save
from uwsim.station.control import CONTROLS
from uwsim.station.helm import answered
from uwsim.station.lease import Lease
from uwsim.station.prepared import Prepared
from uwsim.station.running import PILOTED, Running
from uwsim.station.saves import go_on_with_maps, load_saved, saved_names

STATE = "station/state"
BEAT_S, STATE_S = 0.033, 0.5
DEAD_S = 3.0  # without anything from a pilot, not even an answer to a ping: others may take the controls
LOGGER = logging.getLogger("uwsim.station")
Show = Callable[[LiveSimulator | None, list[Channel], list[Service]], None]


class Station:
    """The operator's station: a guest of a rosbridge server, which `show` gives simulators to.

        station = Station()
        with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
            ...

    offered: the scenario that the start screen begins with. is_fixed: it runs one simulator, which `run` is given: no
    start screen. truth: whether pilots may see the vehicle's true position. wire, origin: see uwsim.channels. threads:
    of simulators. folder: where `save` writes.
    """

    name = "/station"

    def __init__(
        self,
        *,
        offered: str = "lake",
        is_fixed: bool = False,
        truth: bool = True,
        wire: Wire = "both",
        origin: str | Sequence[float] = "world",
        threads: int | None = None,
        folder: Path | None = None,
    ) -> None:
        self.folder = folder or Path.cwd()
        self._offered = offered
        self.is_fixed = is_fixed
        self.running: Running | None = None
        self.lease = Lease()
        self.changed = threading.Event()
        self._options: dict[str, Any] = {"truth": truth, "wire": wire, "origin": origin}
        self._threads = threads
        self._prepared = Prepared(lambda scenario: Simulator(scenario, threads=threads))
        self._show: Show = lambda live, channels, services: None
        self._phase = "starting" if is_fixed else "idle"  # idle shows the start screen
        self._session = 0
        self._numbers = itertools.count(1)
        self._starting = threading.Lock()
        self._closing = threading.Event()
        self._beating: threading.Thread | None = None
        self._said: Values = {}
        self.services = self._services()

    # The graph's side

    def connect(self, node: Node) -> None:
        """Take the end of the graph."""
        self._node = node
        node.offer_topics(self._topics(None))

    def left(self, client: str) -> None:
        """A connection is gone; a pilot's takes the efforts with it."""
        if self.lease.leave(client):
            self._let_go()
        if not self.lease.members:
            self._prepared.forget()  # nobody is at the start screen
        self.changed.set()

    def serving(self, show: Show) -> Self:
        """Give simulators to a server from now on."""
        self._show = show
        return self

    def __enter__(self) -> Self:
        self._beating = threading.Thread(target=self._beat, name="uwsim-station", daemon=True)
        self._beating.start()
        if not self.is_fixed:  # reading all files takes half a second, which the first page should not wait for
            threading.Thread(target=catalog, args=(self._offered,), name="uwsim-catalog", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the simulator."""
        self._closing.set()
        self.changed.set()
        self._prepared.close()
        if self._beating is not None:
            self._beating.join()
        if self.running is not None:
            self.running.stop()

    # Simulators

    def start(self, choice: Values) -> None:
        """Run a simulator of the user's choice instead of the present one. Raises ChoiceError, RuntimeError."""
        if self.is_fixed:
            raise ValueError("this server runs one scenario: start `uwsim station` to choose")
        if choice.get("saved") is not None:
            self._go_on(choice)
            return
        scenario, speed = chosen(choice, self._offered)

        def make() -> LiveSimulator:
            return LiveSimulator(self._prepared.take(scenario), speed=speed)

        try:
            self.run(make)
        except ScenarioError as error:
            raise ChoiceError({"scenario": " ".join(str(error).split())}) from None

    def _go_on(self, choice: Values) -> None:
        """Continue a saved session: everything but the speed is as it was."""
        name, speed = chosen_save(choice, saved_names(self.folder))
        self._prepared.forget()
        folder = self.folder / name
        try:
            self.run(
                lambda: LiveSimulator(load_saved(folder, self._threads), speed=speed),
                lambda running: go_on_with_maps(running, folder),
            )
        except (ValueError, OSError) as error:
            raise ChoiceError({"saved": " ".join(str(error).split())}) from None

    def run(
        self, make: Callable[[], LiveSimulator], prepare: Callable[[Running], object] = lambda running: None
    ) -> None:
        """Run the simulator that `make` makes, instead of the present one, which runs on until then.

        prepare: what is to be done when its channels are there and before its map begins to grow.
        """
        if not self._starting.acquire(blocking=False):
            raise ValueError("another simulator is being started")
        before, running = self._phase, None
        try:
            self._enter("starting")
            running = Running(make(), self._node, **self._options)
            prepare(running)
            self._leave_present()
            self._node.offer_topics(self._topics(running))
            running.start()
            self._show(running.live, running.channels, running.services)
            self.running = running
            self._session = next(self._numbers)
            before = "running"
        finally:
            if running is not None and self.running is not running:  # something failed
                running.stop()
            self._enter(before)
            self._starting.release()

    def quit(self) -> None:
        """End the simulator: back to the start screen. Raises ValueError if there is none."""
        if self.is_fixed:
            raise ValueError("this server runs one scenario: there is nothing else to show")
        with self._starting:
            self._leave_present()
            self._node.offer_topics(self._topics(None))
            self._enter("idle")

    def begin_anew(self) -> None:
        """Take note that simulated time began anew: pages ask for everything again."""
        self._session = next(self._numbers)
        self.changed.set()

    def present(self) -> Running:
        """Return what runs. Raises ValueError if nothing does."""
        if self.running is None:
            raise ValueError("no simulator runs: start one")
        return self.running

    def _leave_present(self) -> None:
        if self.running is not None:
            running, self.running = self.running, None
            self._show(None, [], [])
            running.stop()

    def _enter(self, phase: str) -> None:
        self._phase = phase
        self.changed.set()

    def _let_go(self) -> None:
        running = self.running
        if running is not None:
            running.helm.let_go()

    # What is said

    def _topics(self, running: Running | None) -> list[GuestTopic]:
        state = GuestTopic(STATE, STATION_STATE, "what the station does, and who has the controls", latched=True)
        return [state, *(running.views.topics() if running is not None else [])]

    def _beat(self) -> None:
        """Keep efforts alive or end them, begin pictures and tell the state, until closed."""
        for count in itertools.count():
            if self._closing.wait(BEAT_S):
                return
            running = self.running
            try:
                if running is not None:
                    running.helm.beat()
                    running.views.beat()
                if count % round(STATE_S / BEAT_S) == 0 or self.changed.is_set():
                    self.changed.clear()
                    self._tell_state(running)
            except NotRunningError:
                LOGGER.debug("the simulator has stopped")
            except Exception:
                LOGGER.exception("the station's beat failed")

    def _tell_state(self, running: Running | None) -> None:
        live = None if running is None else running.live
        if running is not None:
            running.notice_changes()
        state = {
            "phase": self._phase if running is not None or self._phase != "running" else "idle",
            "session": self._session,
            "edition": 0 if running is None else running.edition,
            "pilot": self.lease.pilot,
            "member_ids": list(self.lease.members),
            "member_names": list(self.lease.members.values()),
            "asking": list(self.lease.asking),
            "recording": "" if running is None or running.recorder is None else running.recorder.path.name,
        }
        if live is not None:
            state |= {
                "scenario": live.simulator.scenario.name,
                "error": str(live.error or ""),
                "time": 1e-9 * live.time_ns,
                "paused": live.paused,
                "speed": 0.0 if live.speed == "max" else live.speed,
                "factor": live.factor,
                "lateness": live.lateness,
            }
        if state != self._said:
            self._said = state
            self._node.publish(STATE, message(STATION_STATE, **state), 0 if live is None else live.time_ns)

    # What is asked

    def _services(self) -> list[GuestService]:
        quick = (
            ("describe", self._describe, "what runs, and under which names it is seen"),
            ("join", self._join, "take part under a name"),
            ("take_control", self._take_control, "have the controls, if nobody has them"),
            ("hand_over", self._hand_over, "pass the controls on"),
            ("drive", self._drive, "set efforts, by the pilot"),
            ("command", self._command, "give another command, by the pilot"),
            ("set_view", self._set_view, "change the rate, width and quality of a view"),
        )
        start_screen = (
            ("catalog", self._catalog, "what can be chosen on the start screen"),
            ("check", self._check, "say what is wrong with a choice"),
            ("start", self._start, "run a simulator of a choice"),
        )
        control = ("control", self._control, "pause, step, restart, save, record and the like; by the pilot")
        slow = (control,) if self.is_fixed else (*start_screen, control)
        return [
            GuestService(f"station/{name}", f"uwsim_msgs/srv/Station{_camel(name)}", _said(call), text, brief)
            for calls, brief in ((quick, True), (slow, False))
            for name, call, text in calls
        ]

    def _describe(self, caller: str, request: Values) -> Values:
        running = self.present()
        said = {"session": self._session, "edition": running.edition, "is_fixed": self.is_fixed}
        return {"success": True, **said, "controls": self._controls(), **running.describe()}

    def _controls(self) -> list[str]:
        return [name for name in CONTROLS if not (self.is_fixed and name == "quit")]

    def _join(self, caller: str, request: Values) -> Values:
        self.lease.join(caller, request.get("name"))
        self.changed.set()
        return {"success": True, "message": "", "id": caller}

    def _take_control(self, caller: str, request: Values) -> Values:
        self.changed.set()
        if self.lease.pilot != caller:
            self.lease.take(caller, is_silent=self._node.silence_s(self.lease.pilot) > DEAD_S)
            self._let_go()
        return {"success": True, "message": ""}

    def _hand_over(self, caller: str, request: Values) -> Values:
        self.lease.hand_over(caller, request.get("to", ""))
        self._let_go()
        self.changed.set()
        return {"success": True, "message": ""}

    def _drive(self, caller: str, request: Values) -> Future[Values]:
        self.lease.require_pilot(caller)
        return self.present().helm.drive(request)

    def _command(self, caller: str, request: Values) -> Future[Values]:
        self.lease.require_pilot(caller)
        name, vehicle, arguments = request.get("name"), request.get("vehicle"), request.get("args") or {}
        if not isinstance(name, str) or name not in PILOTED or not isinstance(arguments, dict):
            raise ValueError(f"command = {str(name)[:40]!r}: must be one of {', '.join(PILOTED)}")
        live = self.present().live
        given = {str(key): value for key, value in arguments.items()}
        return answered(live, live.command(name, **({"vehicle": vehicle} if vehicle else {}), **given))

    def _set_view(self, caller: str, request: Values) -> Values:
        self.present().views.set_size(request)
        return {"success": True, "message": ""}

    def _catalog(self, caller: str, request: Values) -> Values:
        return {**catalog(self._offered), "saves": saved_names(self.folder)}

    def _check(self, caller: str, request: Values) -> Values:
        if request.get("saved") is None:
            scenario, _ = chosen(request, self._offered)
            if self._phase == "idle" and caller in self.lease.members:
                self._prepared.want(scenario)
        else:
            chosen_save(request, saved_names(self.folder))
        return {"success": True, "message": "", "errors": {}}

    def _start(self, caller: str, request: Values) -> Values:
        if self.running is not None:
            self.lease.require_pilot(caller)
        self.start(request)
        return {"success": True, "message": "", "errors": {}}

    def _control(self, caller: str, request: Values) -> Values:
        self.lease.require_pilot(caller)
        action = request.get("action")
        if action not in self._controls():
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(self._controls())}")
        live = self.present().live
        said = CONTROLS[action](self, request)
        self.changed.set()
        return {"success": True, "message": said or "", "tick": live.tick}


def _said(call: Callable[[str, Values], Any]) -> Callable[[str, Values], Any]:
    """Return a service whose mistakes are said in its answer."""

    def answer(caller: str, request: Values) -> Any:
        try:
            return call(caller, request)
        except ChoiceError as error:
            return {"success": False, "message": str(error), "errors": error.errors}
        except (ValueError, RuntimeError, OSError) as error:
            return {"success": False, "message": str(error)}

    return answer


def _camel(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))
