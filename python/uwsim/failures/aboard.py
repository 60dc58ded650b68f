"""Everything that runs aboard a simulator's vehicles in simulated time, and the faults."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from uwsim.docking import Dock
from uwsim.failures.events import EventLog
from uwsim.failures.failsafe import Failsafe
from uwsim.failures.faults import Faults
from uwsim.failures.program import Program
from uwsim.named import require_names
from uwsim.network import Network
from uwsim.scenario import Scenario
from uwsim.vehicle import Vehicle

ALL_STOPPED = "all_stopped"


class Aboard:
    """The programs of a simulator, by name: its faults first, then its vehicles' failsafes; and their all stop."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._programs: dict[str, Program] = {"faults": faults}
        self._vehicles: Mapping[str, Vehicle] = {}

    def add_failsafes(
        self,
        scenario: Scenario,
        vehicles: Mapping[str, Vehicle],
        *,
        dock: Dock,
        network: Network | None,
        events: EventLog,
        tick: Callable[[], int],
    ) -> dict[str, Failsafe]:
        """Give each vehicle the failsafe that the scenario or its own file says; return them by vehicle."""
        self._vehicles = vehicles
        for name, vehicle in vehicles.items():
            vehicle.gate.changed = partial(_note_all_stop, events, tick, name)
        failsafes = {}
        for entry in scenario.vehicles:
            figures = entry.failsafe or entry.model.failsafe
            if figures is None:
                continue
            vehicle = vehicles[entry.name]
            east, north, up = (dock.exit_world_m if entry.start is None else vehicle.pose.position_world_m).tolist()
            failsafe = Failsafe(
                vehicle, figures, entry.model, home_m=(east, north, up), events=events, step_s=scenario.step_s,
                tick=tick, water_kg=partial(self._faults.water_kg, entry.name),
                link_silence_s=None if network is None else partial(network.silence_s, entry.name),
            )  # fmt: skip
            self._programs[f"failsafe of {entry.name}"] = failsafes[entry.name] = failsafe
            vehicle.gate.failsafe = failsafe
        return failsafes

    def step(self, tick: int, end: int, advance: Callable[[int], None]) -> None:
        """Make the steps from a tick to another by `advance`, in parts that begin where a program is due."""
        if self.is_idle:
            advance(end - tick)
            return
        for steps in self.parts(tick, end):
            advance(steps)

    def parts(self, tick: int, end: int) -> Iterator[int]:
        """Let the programs act that are due, and give the number of steps to the next; so on to the end."""
        programs = self._programs.values()
        while tick < end:
            for program in programs:
                if program.due_tick <= tick:
                    program.act(tick)
            part_end = min(end, max(tick + 1, self.due_tick))
            yield part_end - tick
            tick = part_end

    @property
    def due_tick(self) -> int:
        """The tick at which a program acts next."""
        return min([program.due_tick for program in self._programs.values()])

    @property
    def is_idle(self) -> bool:
        """Whether there is nothing that could become due: no fault and no failsafe."""
        return len(self._programs) == 1 and not self._faults.are_any

    def restart(self, scenario: Scenario) -> None:
        """Be as at the start of a run of a scenario, which may have another seed."""
        self._faults.begin_anew(scenario)
        for program in self._programs.values():
            program.restart()
        for vehicle in self._vehicles.values():
            vehicle.gate.restore(all_stopped=False)

    def save(self) -> dict[str, Any]:
        """Return all that the future depends on, as JSON values."""
        stopped = [name for name, vehicle in self._vehicles.items() if vehicle.all_stopped]
        return {ALL_STOPPED: stopped, **{name: program.save() for name, program in self._programs.items()}}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `save` returned. Raises ValueError for that of other vehicles."""
        require_names("programs", state, (ALL_STOPPED, *self._programs))
        stopped = state[ALL_STOPPED]
        require_names("all_stopped", {*self._vehicles, *stopped}, self._vehicles)
        for name, program in self._programs.items():
            program.restore(state[name])
        for name, vehicle in self._vehicles.items():
            vehicle.gate.restore(all_stopped=name in stopped)


def _note_all_stop(events: EventLog, tick: Callable[[], int], vehicle: str, on: bool) -> None:
    events.add(tick(), vehicle, "all_stop" if on else "all_stop_ends")
