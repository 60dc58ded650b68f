"""The faults and autonomous reactions of a simulator's vehicles."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

from pydantic import ConfigDict

from uwsim.base.agenda import Agenda, Rank
from uwsim.base.named import require_names
from uwsim.base.saved_state import State
from uwsim.scenario import Scenario
from uwsim.simulator.docking import Dock
from uwsim.simulator.failures.events import EventLog, write_note
from uwsim.simulator.failures.failsafe import Failsafe, FailsafeState
from uwsim.simulator.failures.faults import Faults, FaultsState
from uwsim.simulator.holds import Holds, HoldsState
from uwsim.simulator.network import Network
from uwsim.simulator.vehicle import Vehicle

FAILSAFE_OF = "failsafe of "


class ReactionsState(State):
    """Saved Reactions: faults, holds, each failsafe as "failsafe of VEHICLE", and the vehicles with all stop set."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, FailsafeState]
    all_stopped: list[str]
    faults: FaultsState
    holds: dict[str, HoldsState]  # keyed by vehicle, for vehicles with active holds


class Reactions:
    """A simulator's faults, failsafes, holds and all-stop states; they are saved, restored and restarted together."""

    STATE: ClassVar[Any] = ReactionsState

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._failsafes: dict[str, Failsafe] = {}
        self._holds: dict[str, Holds] = {}
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
    ) -> dict[str, Failsafe]:
        """Give each vehicle the failsafe defined in the scenario or in its own file; return them by vehicle."""
        self._vehicles = vehicles
        for name, vehicle in vehicles.items():
            vehicle.helm.changed = partial(_note_all_stop, events, agenda, name)
            vehicle.helm.note = partial(write_note, events, agenda, name)
            self._holds[name] = vehicle.helm.holds = Holds(
                vehicle, agenda=agenda, events=events, step_s=scenario.step_s
            )
        for entry in scenario.vehicles:
            figures = entry.failsafe or entry.model.failsafe
            if figures is None:
                continue
            vehicle = vehicles[entry.name]
            east, north, up = (dock.exit_world_m if entry.start is None else vehicle.pose.position_world_m).tolist()
            failsafe = Failsafe(
                vehicle, figures, entry.model, home_m=(east, north, up), events=events, step_s=scenario.step_s,
                tick=lambda: agenda.tick, water_kg=partial(self._faults.water_kg, entry.name),
                link_silence_s=None if network is None else partial(network.silence_s, entry.name),
            )  # fmt: skip
            self._failsafes[entry.name] = vehicle.helm.failsafe = failsafe
            agenda.add(failsafe, Rank.FAILSAFE, failsafe.act)
        return self._failsafes

    def restart(self, scenario: Scenario) -> None:
        """Return to the start of a run of a scenario, possibly with a different seed."""
        self._faults.restart(scenario)
        for failsafe in self._failsafes.values():
            failsafe.restart()
        for holds in self._holds.values():
            holds.restart()
        for vehicle in self._vehicles.values():
            vehicle.helm.restore(all_stopped=False)

    def save(self) -> dict[str, Any]:
        """Return everything that future steps depend on, as JSON values."""
        stopped = [name for name, vehicle in self._vehicles.items() if vehicle.all_stopped]
        failsafes = {FAILSAFE_OF + name: failsafe.save() for name, failsafe in self._failsafes.items()}
        holds = {name: holds.save() for name, holds in self._holds.items() if holds.has_control or holds.note}
        return {"all_stopped": stopped, "faults": self._faults.save(), "holds": holds, **failsafes}

    def restore(self, state: ReactionsState) -> None:
        """Load a state returned by `save`. Raises ValueError if it belongs to other vehicles."""
        failsafes = state.__pydantic_extra__
        require_names("programs", failsafes, (FAILSAFE_OF + name for name in self._failsafes))
        require_names("all_stopped", {*self._vehicles, *state.all_stopped}, self._vehicles)
        require_names("holds", {*self._vehicles, *state.holds}, self._vehicles)
        self._faults.restore(state.faults)
        for name, failsafe in self._failsafes.items():
            failsafe.restore(failsafes[FAILSAFE_OF + name])
        for name, vehicle in self._vehicles.items():
            vehicle.helm.restore(all_stopped=name in state.all_stopped)
        for name, holds in self._holds.items():
            holds.restart()
            if name in state.holds:
                holds.restore(state.holds[name])


def _note_all_stop(events: EventLog, agenda: Agenda, vehicle: str, on: bool) -> None:
    events.add(agenda.tick, vehicle, "all_stop" if on else "all_stop_ends")
