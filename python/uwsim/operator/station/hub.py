"""The station's node in the graph: starts and stops simulators, and keeps track of the pilot."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Self

from uwsim.bridges.actions import Action, actions_of
from uwsim.channels import Channel, Service
from uwsim.channels.feed import Feed
from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.own_types import STATION_STATE
from uwsim.channels.served import default_origin
from uwsim.channels.table import Wire, checked_wire
from uwsim.exercises import Course, Exercise
from uwsim.live import LiveSimulator
from uwsim.operator.station.choice import (
    ChoiceError,
    catalog,
    chosen,
    chosen_flight,
    chosen_rosbridge,
    chosen_save,
    scenarios,
)
from uwsim.operator.station.flights import FOLDER, Bounds, FlightRecording, Flights
from uwsim.operator.station.instructor import Instructor
from uwsim.operator.station.judged import Judged
from uwsim.operator.station.lease import Lease
from uwsim.operator.station.prepared import Prepared
from uwsim.operator.station.preview import preview_png
from uwsim.operator.station.pulse import STATE, Pulse
from uwsim.operator.station.replay import Replay
from uwsim.operator.station.running import Running
from uwsim.operator.station.saves import go_on_with_maps, load_saved, saved_names
from uwsim.operator.station.services import Services
from uwsim.operator.station.user_rosbridge import UserRosbridge
from uwsim.scenario import ScenarioError
from uwsim.simulator.simulator import Simulator

Show = Callable[[LiveSimulator | None, list[Channel], list[Service], Feed | None, list[Action]], None]


class Station:
    """The operator's station: a guest of a rosbridge server, to which `show` passes simulators.

        station = Station()
        with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
            ...

    offered, link: the scenario that is preselected on the start screen, and its modem if it differs from the
    scenario's. is_fixed: whether to run a single simulator, passed to `run`, without a start screen. truth: whether
    pilots may see the vehicle's true position. wire, origin: see uwsim.channels. If origin is None, it is the world's
    or, for a session that joins the user's rosbridge, the scenario's. threads: the number of threads of simulators.
    folder: where `save` writes. instructor_token: the token of a second page, whose user alone may change the world;
    see `instructor`. keep_flights: how many automatically recorded flights to keep in `folder`/flights, or None to
    record and list none. Raises ValueError for invalid values.

    phase: "idle" (the start screen), "starting" or "running". session: a number that changes with each simulator and
    each restart.
    """

    name = "/station"

    def __init__(
        self,
        *,
        offered: str = "lake",
        link: str | None = None,
        is_fixed: bool = False,
        truth: bool = True,
        wire: Wire = "both",
        origin: str | Sequence[float] | None = None,
        threads: int | None = None,
        folder: Path | None = None,
        instructor_token: str | None = None,
        keep_flights: Bounds | None = None,
    ) -> None:
        # Checked here, so that errors do not appear only when a pilot starts the first simulator.
        checked_wire(wire, "world" if origin is None else origin)
        self.folder = folder or Path.cwd()
        self.instructor = None if instructor_token is None else Instructor(instructor_token, self.folder)
        self.flights = None if keep_flights is None else Flights(self.folder / FOLDER, keep_flights, threads)
        self.offered = offered
        self.link = link
        self.is_fixed = is_fixed
        self.running: Running | None = None
        self.lease = Lease()
        self._options: dict[str, Any] = {"truth": truth, "wire": wire}
        self._origin = origin
        self._threads = threads
        self.prepared = Prepared(lambda scenario: Simulator(scenario, threads=threads))
        self._show: Show = lambda live, channels, services, feed, actions: None
        self.phase = "starting" if is_fixed else "idle"  # idle shows the start screen
        self.session = 0
        self._numbers = itertools.count(1)
        self._starting = threading.Lock()
        self._pulse = Pulse(self)
        self.services = Services(self).all()

    # Called by the graph

    def __repr__(self) -> str:
        return f"<Station: {self.phase}, offers '{self.offered}'>"

    def connect(self, node: Node) -> None:
        """Receive the node through which the station takes part in the graph."""
        self.node = node
        node.offer_topics(self._topics(None))

    def left(self, client: str) -> None:
        """Remove a closed connection. If it was the pilot's, set efforts to zero."""
        if self.instructor is not None:
            self.instructor.clients.discard(client)
        if self.lease.leave(client):
            self.let_go()
        if not self.lease.members:
            self.prepared.forget()  # no client is left at the start screen
        self.tell()

    def demanded(self) -> None:
        """Called when a topic gets its first subscriber: a picture may be due."""
        self._pulse.stir()

    def serving(self, show: Show) -> Self:
        """Start passing simulators to a server."""
        self._show = show
        return self

    def __enter__(self) -> Self:
        self._pulse.start()
        if not self.is_fixed:  # reads all files ahead, which takes half a second, so that the first page need not wait
            threading.Thread(target=catalog, args=(self.offered,), name="uwsim-catalog", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the simulator."""
        if self.flights is not None:
            self.flights.close()
        self._pulse.close()
        self.prepared.close()
        if self.running is not None:
            self.running.stop()

    # Simulators

    def start(self, choice: Values) -> None:
        """Run a simulator for the user's choice, replacing the current one. Raises ChoiceError or RuntimeError."""
        if self.is_fixed:
            raise ValueError("this server runs one scenario: start `uwsim station` to choose")
        if choice.get("saved") is not None:
            self._go_on(choice)
            return
        if choice.get("flight") is not None:
            self._replay(choice)
            return
        scenario, speed = chosen(choice, self.offered)
        rosbridge = chosen_rosbridge(choice)

        def make() -> LiveSimulator:
            return LiveSimulator(self.prepared.take(scenario), speed=speed)

        try:
            self.run(make, rosbridge=rosbridge)
        except ScenarioError as error:
            raise ChoiceError({"scenario": " ".join(str(error).split())}) from None

    def _go_on(self, choice: Values) -> None:
        """Continue a saved session; only the speed is taken from the choice."""
        name, speed = chosen_save(choice, saved_names(self.folder))
        rosbridge = chosen_rosbridge(choice)
        self.prepared.forget()
        folder = self.folder / name
        try:
            self.run(
                lambda: LiveSimulator(load_saved(folder, self._threads), speed=speed),
                lambda running: go_on_with_maps(running, folder),
                rosbridge=rosbridge,
            )
        except (ValueError, OSError) as error:
            raise ChoiceError({"saved": " ".join(str(error).split())}) from None

    def _replay(self, choice: Values) -> None:
        """Replay a flight; only the speed is taken from the choice."""
        name, speed = chosen_flight(choice)
        flights = self._kept_flights()
        self.prepared.forget()
        try:
            timeline = flights.timeline(name)
            live = LiveSimulator(timeline.simulator(), speed=speed)
            self.run(lambda: live, replay=Replay(live, timeline, name, flights))
        except (ValueError, OSError) as error:
            raise ChoiceError({"flight": " ".join(str(error).split())}) from None

    def take_helm(self) -> str:
        """Start flying from the current moment of a replay, in a new session; return a text with the starting point.

        Efforts are zero at first. Time continues or remains paused, as before. Raises ValueError.
        """
        replay = self.present().replay
        if replay is None:
            raise ValueError("no flight is replayed")
        timeline, was_paused = replay.timeline, replay.live.paused
        replay.live.pause()
        state, time_s = replay.live.read(lambda sim: (sim.save_state(), sim.time_s)).result()
        where = f"{replay.flight} at {time_s:.2f} s"

        def make() -> LiveSimulator:
            sim = timeline.simulator()
            sim.restore_state(state)
            for vehicle in sim.vehicles.values():
                vehicle.set_effort()
            return LiveSimulator(sim, speed=1.0, paused=was_paused)

        def prepare(running: Running) -> None:
            running.branched_from = where

        self.run(make, prepare, notes={"branched_from": where})
        return where

    def _kept_flights(self) -> Flights:
        if self.flights is None:
            raise ValueError("this station keeps no flights")
        return self.flights

    def run(
        self,
        make: Callable[[], LiveSimulator],
        prepare: Callable[[Running], object] = lambda running: None,
        feed: Feed | None = None,
        rosbridge: UserRosbridge | None = None,
        replay: Replay | None = None,
        notes: Values | None = None,
    ) -> None:
        """Run the simulator returned by `make`. The current simulator keeps running until it is replaced.

        prepare: called once the new simulator's channels exist, before its map is built. feed: shared with other sinks.
        rosbridge: the user's server, which the simulator joins. replay: the replay that the simulator follows. notes:
        metadata for the recording of the flight.
        """
        if not self._starting.acquire(blocking=False):
            raise ValueError("another simulator is being started")
        before, running = self.phase, None
        try:
            self._enter("starting")
            live = make()
            origin = self._origin
            if origin is None:
                origin = "world" if rosbridge is None else default_origin(live.simulator.scenario)
            running = Running(
                live, self.node, self._pulse.stir, feed=feed, origin=origin, folder=self.folder, replay=replay,
                **self._options,
            )  # fmt: skip
            if self.flights is not None and replay is None:
                running.flight = FlightRecording(running, self.flights, notes)
            if self.instructor is not None:
                running.hide_the_simulation()
                self.instructor.begin()
            running.table.rights.pilot = lambda: self.lease.pilot_name
            prepare(running)
            self._leave_present()
            self.node.offer_topics(self._topics(running))
            running.start()
            actions = actions_of(running.live.simulator, running.table)
            self._show(running.live, running.table.channels, running.table.services, running.feed, actions)
            if rosbridge is not None:
                running.join(rosbridge)
            self.running = running
            self.session = next(self._numbers)
            before = "running"
        finally:
            if running is not None and self.running is not running:  # something failed
                running.stop()
            self.phase = before
            self._starting.release()  # first, since a page that sees the phase may start the next one at once
            self.tell()

    def run_exercise(self, exercise: Exercise) -> None:
        """Run an exercise, with its score sheets in `folder`. Raises ScenarioError or ValueError."""

        def make() -> LiveSimulator:
            sim = Simulator(exercise.made_scenario(), threads=self._threads)
            Course.require_events(exercise, sim)
            return LiveSimulator(sim)

        def judge(running: Running) -> None:
            running.judged = Judged(running.live, exercise, self.folder)
            running.scene.hidden = frozenset(exercise.hidden)

        self.run(make, judge)

    def preview(self, scenario: str) -> bytes:
        """Return a PNG of an offered scenario seen from above. Raises LookupError, ScenarioError or OSError."""
        if self.is_fixed or scenario not in scenarios(self.offered):
            raise LookupError(scenario)
        return self.prepared.afterwards(lambda: preview_png(scenario))  # preparing a simulator has priority

    def quit(self) -> None:
        """Stop the simulator and return to the start screen. Raises ValueError if there is none."""
        if self.is_fixed:
            raise ValueError("this server runs one scenario: there is nothing else to show")
        with self._starting:
            self._leave_present()
            self.node.offer_topics(self._topics(None))
            self.phase = "idle"
        self.tell()

    def rewind(self, state: bytes | None = None) -> None:
        """Return to a saved state, by default the initial state, in a new session.

        Pages then request everything again. The recording of the flight ends, and a new recording begins. Raises
        ValueError.
        """
        running = self.present()
        if running.flight is not None:
            running.flight.stop()
        try:
            running.live.reset(state)
        finally:
            if running.flight is not None:
                running.flight.start()
        self.session = next(self._numbers)
        self.tell()

    def present(self) -> Running:
        """Return the running simulator. Raises ValueError if there is none."""
        if self.running is None:
            raise ValueError("no simulator is running: start one")
        return self.running

    def _leave_present(self) -> None:
        if self.running is not None:
            if self.running.flight is not None:
                self.running.flight.stop()  # first, so that the start screen finds it
            running, self.running = self.running, None
            self._show(None, [], [], None, [])
            running.stop()

    def _enter(self, phase: str) -> None:
        self.phase = phase
        self.tell()

    def let_go(self) -> None:
        """Set efforts to zero."""
        running = self.running
        if running is not None and running.replay is None:
            running.end_plan("the controls have passed on")
            running.helm.let_go()

    def tell(self) -> None:
        """Publish the state; called when it has changed."""
        self._pulse.tell()

    def _topics(self, running: Running | None) -> list[GuestTopic]:
        state = GuestTopic(STATE, STATION_STATE, "what the station does, and who has the controls", latched=True)
        return [state, *(running.topics() if running is not None else [])]
