"""What a simulator's vehicles do by themselves, and what fails in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from uwsim.agenda import Agenda, Rank
from uwsim.docking import Dock
from uwsim.failures.events import EventLog
from uwsim.failures.failsafe import Failsafe
from uwsim.failures.faults import Faults
from uwsim.named import require_names
from uwsim.network import Network
from uwsim.scenario import Scenario
from uwsim.vehicle import Vehicle

ALL_STOPPED, FAULTS, FAILSAFE_OF = "all_stopped", "faults", "failsafe of "


class Aboard:
    """The faults of a simulator, its vehicles' failsafes and their all stop: saved, restored and restarted together."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._failsafes: dict[str, Failsafe] = {}
        self._vehicles: Mapping[str, Vehicle] = {}

    def add_failsafes(
        self,
        scenario: Scenario,
        vehicles: Mapping[str, Vehicle],
        *,
        dock: Dock,
        network: Network | None,
        events: EventLog,
        agenda: Agenda,
        tick: Callable[[], int],
    ) -> dict[str, Failsafe]:
        """Give each vehicle the failsafe of the scenario or of its own file; return them by vehicle."""
        self._vehicles = vehicles
        for name, vehicle in vehicles.items():
            vehicle.gate.changed = partial(_note_all_stop, events, tick, name)
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
            self._failsafes[entry.name] = vehicle.gate.failsafe = failsafe
            agenda.add(failsafe, Rank.FAILSAFE, failsafe.act)
        return self._failsafes

    def restart(self, scenario: Scenario) -> None:
        """Be as at the start of a run of a scenario, which may have another seed."""
        self._faults.restart(scenario)
        for failsafe in self._failsafes.values():
            failsafe.restart()
        for vehicle in self._vehicles.values():
            vehicle.gate.restore(all_stopped=False)

    def save(self) -> dict[str, Any]:
        """Return all that the future depends on, as JSON values."""
        stopped = [name for name, vehicle in self._vehicles.items() if vehicle.all_stopped]
        failsafes = {FAILSAFE_OF + name: failsafe.save() for name, failsafe in self._failsafes.items()}
        return {ALL_STOPPED: stopped, FAULTS: self._faults.save(), **failsafes}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `save` returned. Raises ValueError for that of other vehicles."""
        require_names("programs", state, (ALL_STOPPED, FAULTS, *(FAILSAFE_OF + name for name in self._failsafes)))
        stopped = state[ALL_STOPPED]
        require_names("all_stopped", {*self._vehicles, *stopped}, self._vehicles)
        self._faults.restore(state[FAULTS])
        for name, failsafe in self._failsafes.items():
            failsafe.restore(state[FAILSAFE_OF + name])
        for name, vehicle in self._vehicles.items():
            vehicle.gate.restore(all_stopped=name in stopped)


def _note_all_stop(events: EventLog, tick: Callable[[], int], vehicle: str, on: bool) -> None:
    events.add(tick(), vehicle, "all_stop" if on else "all_stop_ends")
