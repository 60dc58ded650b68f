"""The service of the scene editor: who may edit, its requests, and an edited scenario in the paused simulator."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.channels.guest import Values
from uwsim.live import LiveSimulator
from uwsim.operator.station.controls.lease import Lease
from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.sessions.saves import continue_maps
from uwsim.operator.station.sessions.sessions import Sessions
from uwsim.operator.station.start.choice import ChoiceError, scenarios, with_choice
from uwsim.scenario import Scenario
from uwsim.scenario.read.assets import find_yaml
from uwsim.simulator.simulator import Simulator

CHANGES = ("set", "add", "move", "remove", "undo", "redo", "revert")
GONE_S = 3.0  # a client that sends nothing for this long, not even replies to pings, edits no longer
OPENS = ("open", "new")
ACTIONS = (*OPENS, "report", *CHANGES, "check", "save", "meshes", "upload", "apply", "close")
SAME = "it needs the same vehicles, with the same parts: save the scenario, and start it"


class EditService:
    """Handles the requests to edit a scenario.

    On the start screen, a member may open one if no other member edits; while a simulator runs, the pilot alone. The
    next to open a scenario in which unsaved changes were left continues with them.
    """

    def __init__(self, sessions: Sessions, lease: Lease) -> None:
        self._sessions, self._lease = sessions, lease
        self._editor = sessions.editor
        self._of: Running | None = None  # whose scenario is edited, if it is that of a simulator

    def answer(self, caller: str, request: Values) -> Values:
        """Return the response to a request; see wire.editor.Edit. Raises ValueError or OSError."""
        action, message = request.get("action"), ""
        more: Values = {}
        if action not in ACTIONS:
            raise ValueError(f"action = {str(action)[:40]!r}: must be one of {', '.join(ACTIONS)}")
        if action != "report":
            self._require(caller, is_open=action in OPENS)
        if action in OPENS:
            if self._open(caller, request.get("scenario"), is_new=action == "new"):
                message = "continues with what was not saved"
        elif action == "check":
            more = {"mistakes": self._editor.mistakes()}
        elif action == "save":
            message = f"saved as {self._editor.save(request.get('name'))}"
        elif action == "meshes":
            more = {"meshes": self._editor.meshes.names()}
        elif action == "upload":
            more = self._editor.meshes.receive(request)
        elif action == "apply":
            if self._sessions.present() is not self._of:
                raise ValueError("the edited scenario is not the running simulator's: open that one")
            rebuild(self._sessions, self._editor.draft.scenario)
            self._of = self._sessions.running
            message = "the world is rebuilt"
        elif action == "close":
            self._editor.close(caller)
        elif action in CHANGES:
            more = {"added": list(self._editor.act(request))}
        by = self._lease.members.get(self._editor.by, "")
        state = self._editor.state(by)
        if state["is_open"]:
            state["is_of_running"] = self._of is not None and self._of is self._sessions.running
        return {"success": True, "message": message, **state, **more}

    def _require(self, caller: str, *, is_open: bool) -> None:
        """Raise ValueError unless a client may edit now."""
        if self._sessions.running is None:
            self._lease.require_member(caller)
        else:
            self._lease.require_pilot(caller)
        by = self._editor.by
        is_gone = by not in self._lease.members or self._sessions.node.silence_s(by) > GONE_S
        is_free = is_open and (not by or is_gone or self._sessions.running is not None)  # there are rights for that
        if by != caller and not is_free:
            by_name = self._lease.members.get(by, "another client")
            raise ValueError(f"{by_name} edits a scenario" if by else "open a scenario first")

    def _open(self, caller: str, name: object, *, is_new: bool) -> bool:
        """Open a new scene, a scenario, or that of the simulator; return True if unsaved changes were left in it."""
        running = None
        if is_new:
            if self._sessions.running is not None:
                raise ValueError("a new scene is built on the start screen: quit first")
            is_kept = self._editor.open_new(caller)
        elif name is None:
            running, choice = self._sessions.present(), self._sessions.choice
            scenario = running.live.simulator.scenario
            is_kept = self._editor.open_running(
                caller,
                scenario,
                lambda found: with_choice(found, choice, {}) == scenario,
                is_of_same=self._of is running,
            )
        else:
            saved = self._editor.saved
            known = [*saved, *scenarios(self._sessions.offered)]
            if not isinstance(name, str) or name not in known:
                raise ValueError(f"scenario = {str(name)[:40]!r}: must be one of {', '.join(known)}")
            path = saved[name] if name in saved else find_yaml(name, "scenarios")
            is_kept = self._editor.open(caller, name, Path(path), is_of_same=self._of is None)
        self._of = running
        return is_kept


def rebuild(sessions: Sessions, edited: Scenario) -> None:
    """Continue with an edited scenario, to which the choice made on the start screen applies, too.

    Efforts are zero at first. Raises ScenarioError, ChoiceError or ValueError; the present simulator then stays.
    """
    running, choice = sessions.present(), sessions.choice
    if reason := _hindrance(running):
        raise ValueError(f"the world cannot be rebuilt: {reason}")
    errors: dict[str, str] = {}
    scenario = with_choice(edited, choice, errors)
    if errors:
        raise ChoiceError(errors)
    live = running.live

    def make() -> LiveSimulator:
        sim = Simulator(scenario, threads=sessions.threads)
        try:
            live.read(sim.take_over).result()
        except ValueError as error:
            raise ValueError(f"the world cannot be rebuilt: {error}; {SAME}") from None
        for vehicle in sim.vehicles.values():
            if (name := sim.world.solid_around(vehicle.pose.position_world_m)) is not None:
                raise ValueError(f"the world cannot be rebuilt: vehicle '{vehicle.name}' would be inside '{name}'")
            vehicle.set_effort()
        return LiveSimulator(sim, speed=live.speed, paused=True)

    with TemporaryDirectory() as folder:
        for name, ping_map in running.maps.items():
            ping_map.write(Path(folder) / f"{name}.ot")
        sessions.run(make, lambda rebuilt: continue_maps(rebuilt, Path(folder)), choice=choice)
    for name, vehicle in live.simulator.vehicles.items():
        if vehicle.helm.all_stopped:  # perhaps since the state was taken over
            sessions.present().live.command("all_stop", vehicle=name, on=True).result()


def _hindrance(running: Running) -> str:
    if running.replay is not None:
        return "a flight is replayed"
    if running.judged is not None:
        return "an exercise is flown"
    if running.rosbridge is not None:
        return "it has joined your rosbridge"
    return "" if running.live.paused else "it runs: pause it first"
