"""The station's sessions: simulators started, continued, replayed, branched and returned to, one at a time."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from uwsim.bridges.actions import Offered, actions_of
from uwsim.channels import Channel, Service
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.ros.own_types import STATION_STATE
from uwsim.channels.served import default_origin
from uwsim.exercises import Exercise, load_exercise
from uwsim.exercises.exercise import next_exercise
from uwsim.exercises.flyable import flyable
from uwsim.live import LiveSimulator
from uwsim.operator.station.controls.lease import Lease
from uwsim.operator.station.editor import Editor
from uwsim.operator.station.flights.flights import FlightRecording, Flights
from uwsim.operator.station.flights.replay import Replay
from uwsim.operator.station.sessions.exercise import Judged
from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.sessions.saves import continue_maps, load_saved, saved_names
from uwsim.operator.station.start.choice import (
    ChoiceError,
    chosen,
    chosen_exercise,
    chosen_flight,
    chosen_rosbridge,
    chosen_save,
    scenarios,
)
from uwsim.operator.station.start.prepared import Prepared
from uwsim.operator.station.start.preview import draw, preview_png
from uwsim.operator.station.start.still import still, still_jpg
from uwsim.operator.station.start.user_rosbridge import UserRosbridge
from uwsim.scenario import ScenarioError, load
from uwsim.simulator.simulator import Simulator

Phase = Literal["idle", "starting", "running"]
Show = Callable[[LiveSimulator | None, list[Channel], list[Service], Feed | None, list[Offered]], None]
STATE = "station/state"


class Sessions:
    """Runs one simulator at a time. The current one keeps running until the next can replace it.

    lease: determines who has the helms. wake: called when a picture may be due. publish: called when the state has
    changed. offered, is_fixed, folder, threads, origin: as for `Station`. flights: where recordings are kept, if at
    all. options: of `Running`.

    phase: "idle" is the start screen. number: changes with each simulator and each restart. node, show: set by the
    server that the station joins.
    """

    def __init__(
        self,
        lease: Lease,
        wake: Callable[[], object],
        publish: Callable[[], object],
        *,
        offered: str,
        is_fixed: bool,
        folder: Path,
        threads: int | None,
        origin: str | Sequence[float] | None,
        flights: Flights | None,
        **options: Any,
    ) -> None:
        self._lease, self._wake, self._publish = lease, wake, publish
        self.offered, self.is_fixed, self.folder, self.flights = offered, is_fixed, folder, flights
        self.threads, self._origin, self._options = threads, origin, options
        self.prepared = Prepared(lambda scenario: Simulator(scenario, threads=threads))
        self.node: Node
        self.show: Show = lambda live, channels, services, feed, actions: None
        self.running: Running | None = None
        self.phase: Phase = "starting" if is_fixed else "idle"
        self.number = 0
        self.editor = Editor(folder, threads)
        self.choice: Values = {}  # of which the running simulator is made, if any
        self._person = ""  # who flies the exercise, if that was stated
        self._numbers = itertools.count(1)
        self._starting = threading.Lock()

    def start(self, choice: Values) -> None:
        """Run a simulator for the user's choice. Raises ChoiceError, ValueError or RuntimeError."""
        if choice.get("exercise_name") is not None:
            self._train(choice)
            return
        if self.is_fixed:
            raise ValueError("this server runs one scenario: start `uwsim station` to choose")
        if choice.get("saved") is not None:
            self._continue(choice)
        elif choice.get("flight") is not None:
            self._replay(choice)
        else:
            scenario, speed = chosen(choice, self.offered, self.editor.saved)
            rosbridge = chosen_rosbridge(choice)
            with _errors_of("scenario", ScenarioError):
                self.run(
                    lambda: LiveSimulator(self.prepared.release(scenario), speed=speed),
                    rosbridge=rosbridge,
                    choice=choice,
                )

    def _train(self, choice: Values) -> None:
        """Run an exercise that is packaged or beside a saved scene: from the start screen, or after another one."""
        follows = self.running is not None and self.running.judged is not None
        if self.is_fixed and not follows:
            raise ValueError("exercise_name: this server runs one scenario")
        own = self.editor.exercises
        name = chosen_exercise(choice, own)
        self.prepared.forget()
        with _errors_of("exercise_name", ScenarioError, ValueError):
            self.run_exercise(load_exercise(own.get(name, name)), self._person if follows else "", name)

    def _continue(self, choice: Values) -> None:
        """Continue a saved session; only the speed is taken from the choice."""
        name, speed = chosen_save(choice, saved_names(self.folder))
        rosbridge = chosen_rosbridge(choice)
        self.prepared.forget()
        folder = self.folder / name
        with _errors_of("saved", ValueError, OSError):
            self.run(
                lambda: LiveSimulator(load_saved(folder, self.threads), speed=speed),
                lambda running: continue_maps(running, folder),
                rosbridge=rosbridge,
            )

    def _replay(self, choice: Values) -> None:
        """Replay a flight; only the speed is taken from the choice."""
        name, speed = chosen_flight(choice)
        if self.flights is None:
            raise ValueError("this station keeps no flights")
        self.prepared.forget()
        with _errors_of("flight", ValueError, OSError):
            timeline = self.flights.timeline(name)
            live = LiveSimulator(timeline.simulator(), speed=speed)
        self.run(lambda: live, replay=Replay(live, timeline, name))

    def branch(self) -> str:
        """Start flying from the current moment of a replay, in a new session; return a text with the starting point.

        Efforts are zero at first. Time continues or remains paused, as before. Raises ValueError.
        """
        replay = self.present().replayed
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

    def run_exercise(self, exercise: Exercise, person: str = "", name: str = "") -> None:
        """Run an exercise, with its score sheets in `folder`, without the truth. Raises ScenarioError or ValueError.

        person: the name on the sheets, by default that of the member who begins the attempt. name:
        of a packaged exercise, after which the pilot may start the next one.
        """
        self._person = person

        def make() -> LiveSimulator:
            nonlocal exercise
            exercise, sim = flyable(exercise, self.threads)
            return LiveSimulator(sim, paused=True)  # until the pilot begins

        def judge(running: Running) -> None:
            running.judged = Judged(
                running.live, exercise, self.folder, running.table.rights,
                aids=running.aids_in_use, pilot=lambda: self._lease.pilot_name, person=person, name=name,
                following=next_exercise(name),
                recording=lambda: "" if running.flight is None else running.flight.name,
            )  # fmt: skip
            running.scene.hidden = frozenset(exercise.hidden)

        self.run(make, judge, notes={"exercise": exercise.title}, truth=False)

    def run(
        self,
        make: Callable[[], LiveSimulator],
        prepare: Callable[[Running], object] = lambda running: None,
        feed: Feed | None = None,
        rosbridge: UserRosbridge | None = None,
        replay: Replay | None = None,
        notes: Values | None = None,
        choice: Values | None = None,
        truth: bool | None = None,
    ) -> None:
        """Run the simulator returned by `make`.

        prepare: called once the new simulator's channels exist, before its map is built. feed: shared with other sinks.
        rosbridge: the user's server, which the simulator joins. replay: the replay that the simulator follows. notes:
        metadata for the recording of the flight. choice: of which the simulator is made. truth: as of `Station`, which
        is the default.
        """
        if not self._starting.acquire(blocking=False):
            raise ValueError("another simulator is being started")
        before, running = self.phase, None
        try:
            self.phase = "starting"
            self._publish()
            live = make()
            origin = self._origin
            if origin is None:
                origin = "world" if rosbridge is None else default_origin(live.simulator.scenario)
            running = Running(
                live, self.node, self._wake, feed=feed, origin=origin, folder=self.folder, replay=replay,
                **self._options | ({} if truth is None else {"truth": truth}),
            )  # fmt: skip
            if self.flights is not None and replay is None:
                running.flight = FlightRecording(live, running.table, running.feed, self.flights, notes)
            running.pilot.pass_to(self._lease.pilot_name)
            prepare(running)
            self._end()
            self._offer(running)
            running.start()
            self.show(
                live,
                running.table.channels,
                running.table.services,
                running.feed,
                actions_of(live.simulator, running.table),
            )
            if rosbridge is not None:
                running.join(rosbridge)
            self.running, self.choice = running, choice or {}
            self._lease.lost_by = ""  # the helm of another simulator, for which there is no one to come back
            self.pass_helm()  # again, since the pilot may have changed meanwhile
            self.number = next(self._numbers)
            before = "running"
        finally:
            if running is not None and self.running is not running:  # something failed
                running.stop()
            self.phase = "idle" if before == "running" and self.running is None else before
            self._starting.release()  # first, since a page that sees the phase may start the next one at once
            self._publish()

    def rewind(self) -> None:
        """Return to the initial state, in a new session.

        Pages then request everything again. The recording of the flight ends, and a new recording begins. An attempt
        at an exercise is broken off. Raises ValueError.
        """
        running = self.present()
        if running.judged is not None:
            running.end_plan("the exercise was restarted")
            running.judged.break_off("broken off: the exercise was restarted")
        if running.flight is not None:
            running.flight.stop()
        try:
            with running.live.privileged():
                running.live.reset()
        finally:
            if running.flight is not None:
                running.flight.start()
        self.number = next(self._numbers)
        self._publish()

    def quit(self) -> None:
        """Stop the simulator and return to the start screen. Raises ValueError for a fixed scenario."""
        if self.is_fixed:
            raise ValueError("this server runs one scenario: there is nothing else to show")
        with self._starting:
            self.phase = "starting"  # until all has ended: a page that sees "idle" may start the next one at once
            try:
                self._end()
                self._offer(None)
            finally:
                self.phase = "idle"
        self._lease.lost_by = ""
        self._publish()

    def close(self) -> None:
        """Stop the simulator for good."""
        if self.flights is not None:
            self.flights.close()
        self.prepared.close()
        if self.running is not None:
            self.running.stop()

    def present(self) -> Running:
        """Return the running simulator. Raises ValueError if there is none."""
        if self.running is None:
            raise ValueError("no simulator is running: start one")
        return self.running

    def preview(self, scenario: str, suffix: str) -> bytes:
        """Return a picture of an offered scenario: a PNG from above, or a JPEG from its view.

        Raises LookupError, ScenarioError or OSError.
        """
        path = None if self.is_fixed else self.editor.saved.get(scenario)
        if self.is_fixed or (path is None and scenario not in scenarios(self.offered)):
            raise LookupError(scenario)
        self.prepared.afterwards(lambda: None)  # preparing a simulator has priority
        if suffix == "png":
            return preview_png(scenario) if path is None else draw(load(path))
        return still_jpg(scenario) if path is None else still(load(path))

    def connect(self, node: Node) -> None:
        """Set the node through which simulators take part in the graph."""
        self.node = node
        self._offer(None)

    def pass_helm(self) -> None:
        """Give the vehicles' helms to the present pilot, if there is one."""
        if self.running is not None:
            self.running.pilot.pass_to(self._lease.pilot_name)

    def change_pilot(self) -> None:
        """Pass the helms on, end the plan and set efforts to zero, because the pilot has changed."""
        self.pass_helm()
        running = self.running
        if running is not None and running.replay is None:
            running.end_plan("the controls have passed on")
            running.pilot.release()

    def _end(self) -> None:
        if self.running is not None:
            if self.running.flight is not None:
                self.running.flight.stop()  # first, so that the start screen finds it
            running, self.running = self.running, None
            self.show(None, [], [], None, [])
            running.stop()

    def _offer(self, running: Running | None) -> None:
        state = GuestTopic(STATE, STATION_STATE, "what the station does, and who has the controls", latched=True)
        self.node.offer_topics([state, *(running.topics() if running is not None else [])])


@contextmanager
def _errors_of(field: str, *kinds: type[Exception]) -> Iterator[None]:
    """Report errors of these kinds as errors of a field of the choice."""
    try:
        yield
    except kinds as error:
        raise ChoiceError({field: " ".join(str(error).split())}) from None
