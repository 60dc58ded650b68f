"""Replays a flight at the station, with a live simulator that follows a recording instead of a pilot."""

from __future__ import annotations

from concurrent.futures import Future

from uwsim.base.agenda import NEVER, Rank
from uwsim.base.arguments import is_number
from uwsim.channels.guest import Values
from uwsim.live import PACE_ACTS, LiveSimulator
from uwsim.recording.timeline import Timeline
from uwsim.simulator.simulator import Simulator

REFUSAL = "this is a replay: take the helm to command the vehicle"


class Replay:
    """Issues a recording's commands to a live simulator, and sets its time. Others may only watch the simulator.

    Every position on the time line is simulated from the nearest saved state, so it does not depend on how it was
    reached. At the end of the recording, time stops. flight: the flight's name, as in `Flights`.
    """

    def __init__(self, live: LiveSimulator, timeline: Timeline, flight: str) -> None:
        self.live, self.timeline, self.flight = live, timeline, flight
        self.due_tick = NEVER
        self._place = 0

    def start(self) -> None:
        """Begin to follow the recording, and refuse commands. Call this before the simulator steps."""
        self.live.refusal_of = lambda act: "" if act in PACE_ACTS else REFUSAL
        self.live.simulator.agenda.add(self, Rank.REPLAY, self._act)
        self._go_on_from(self.timeline.place(self.live.simulator.tick))

    def seek(self, time_s: object) -> Future[None]:
        """Go to a simulated time, clamped to the recording, without pausing or resuming. Raises ValueError."""
        if not is_number(time_s):
            raise ValueError(f"time_s = {str(time_s)[:40]}: must be a number")
        line = self.timeline
        tick = round(min(max(time_s / line.step_s, line.start_tick), line.end_tick))
        return self.live.follow(lambda sim: self._seek(sim, tick))

    def resume(self) -> None:
        """Let time continue, or restart from the beginning if at the end."""
        if self.live.tick >= self.timeline.end_tick:
            self.seek(self.timeline.start_tick * self.timeline.step_s).result()
        self.live.resume()

    def step(self, steps: int) -> None:
        """Make steps while paused, not beyond the end. Raises ValueError."""
        left = self.timeline.end_tick - self.live.tick
        if left <= 0:
            raise ValueError("the recording ends here")
        self.live.step(min(steps, left))

    def describe(self) -> Values:
        """Return the entry `replay` of `/station/describe`."""
        line, notes = self.timeline, self.timeline.recording.notes
        return {
            "flight": self.flight,
            "start_s": line.start_tick * line.step_s,
            "end_s": line.end_tick * line.step_s,
            "branched_from": str(notes.get("branched_from", "")),
            "events": [
                {**event._asdict(), "details": [each._asdict() for each in event.details]} for event in line.events
            ],
        }

    def _seek(self, sim: Simulator, tick: int) -> None:
        self.due_tick = NEVER  # while the time line itself issues the commands
        self._go_on_from(self.timeline.go_to(sim, tick, self._place))

    def _act(self, tick: int) -> None:
        line = self.timeline
        while (due := line.next_command_tick(self._place)) is not None and due <= tick:
            line.execute(self.live.simulator, self._place)
            self._place += 1
        self._go_on_from(self._place, tick)
        if tick >= line.end_tick and not self.live.paused:
            self.live.pause()

    def _go_on_from(self, place: int, acted_tick: int = -1) -> None:
        self._place = place
        due = self.timeline.next_command_tick(place)
        self.due_tick = max(self.timeline.end_tick if due is None else due, acted_tick + 1)
