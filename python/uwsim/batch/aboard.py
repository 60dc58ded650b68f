"""The onboard programs of one batch member: its faults and its vehicles' failsafes, as in a Simulator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.agenda import Agenda
from uwsim.base.journal import Journal
from uwsim.batch.members import Member
from uwsim.scenario import Scenario, VehicleEntry
from uwsim.scenario.build.control import ControlSettings
from uwsim.scenario.build.simulation import simulation_spec
from uwsim.scenario.build.station import dock_position, exit_position
from uwsim.scenario.build.vehicle import vehicle_errors_at, vehicle_spec
from uwsim.scenario.build.world import scenario_water
from uwsim.simulator.docking import Dock
from uwsim.simulator.failures import Aboard, EventLog, Failsafe, Faults
from uwsim.simulator.network import Network
from uwsim.simulator.parameters import Parameters
from uwsim.simulator.vehicle import Vehicle


class MemberAboard:
    """A member's onboard programs; valid until the member is reset.

    events: the log of faults, alarms and failsafes so far. faults: injects and ends faults. failsafes: each vehicle's
    failsafe, keyed by vehicle name; see uwsim.simulator.failures.Failsafe for `state`, `cause`, `alarms` and
    `override`. agenda: schedules these programs.
    """

    agenda: Agenda
    events: EventLog
    faults: Faults
    failsafes: Mapping[str, Failsafe]

    def __init__(
        self,
        core: _core.Simulation,
        world: _core.World,
        scene: _core.RayScene,
        member: Member,
        control: Sequence[ControlSettings],
    ) -> None:
        """core: the newly created member, which is not changed. control: the control settings of each vehicle.

        Raises ValueError for faults in parts that the member does not have.
        """
        scenario = member.original
        self._core, self._world, self._water = core, world, member.water
        self._specs, self._step_s = list(member.vehicles), scenario.step_s
        self.agenda = Agenda(lambda: core.tick)
        self._journal = Journal(self.agenda)
        station = scenario.station
        yaw_rad = float(np.radians(station.yaw_deg))
        dock = Dock(core, scene, dock_position(station), exit_position(station), yaw_rad)
        self._vehicles = {
            entry.name: self._vehicle(k, entry, dock, control[k]) for k, entry in enumerate(member.scenario.vehicles)
        }
        self._sensors = [list(vehicle.sensors.values()) for vehicle in self._vehicles.values()]
        network = None
        if scenario.link is not None and scenario.link.modem.kind != "none":
            network = Network(core, scenario, scenario.link.modem, self._journal)
        self.events = EventLog(scenario.step_s)
        self.faults = Faults(
            scenario, self._vehicles, events=self.events, journal=self._journal, agenda=self.agenda,
            apply=lambda: self._parameters.lay_anew(), network=network, has_channels=False,
        )  # fmt: skip
        self._parameters = Parameters(member.scenario, self._change, self._journal.note, {}, self.faults.overlay)
        self._programs = Aboard(self.faults)
        self.failsafes = self._programs.add_failsafes(
            scenario, self._vehicles, dock=dock, network=network, events=self.events, agenda=self.agenda
        )

    def __repr__(self) -> str:
        return f"<MemberAboard: {self.events!r}, {self.faults!r}>"

    def _vehicle(self, index: int, entry: VehicleEntry, dock: Dock, control: ControlSettings) -> Vehicle:
        return Vehicle(
            self._core,
            index,
            self._specs[index],
            dock=dock,
            cameras={},
            lamps={},
            imaging_sonars={},
            journal=self._journal,
            sensors_on={name: sensor.on for name, sensor in entry.model.sensors.items()},
            step_s=self._step_s,
            navigate=_no_estimate,
            control=control,
        )

    @property
    def tick(self) -> int:
        """The number of steps since the start of the member."""
        return self._core.tick

    def acts_within(self, steps: int) -> bool:
        """Return whether anything is due within this many steps."""
        return self.agenda.due_tick < self.tick + steps

    def hear_effort(self, vehicle: str, effort: NDArray[np.float64]) -> None:
        """Record that an effort (6,) was set, so the vehicle is not silent; a steering failsafe overrides it."""
        if vehicle in self.failsafes:
            self._vehicles[vehicle].set_effort(*effort.tolist())

    def tell(
        self, vehicle: int, sensor: int, noise: bool, values: NDArray[np.float64], valid: NDArray[np.bool_]
    ) -> None:
        """Convert a sample to the sensor's reading, as Sensor.read does.

        `values` (width,) and `valid` (1,) are modified in place.
        """
        instrument = self._sensors[vehicle][sensor]
        if not instrument.on:
            values[...], valid[...] = np.nan, False
        elif noise and instrument.distortion is not None:
            fields = _core.sensor_kind(instrument.kind).fields
            values[...] = instrument.distortion.of_rows(values[None], fields)[0]

    def camera_is_on(self, vehicle: str, camera: str) -> bool:
        """Return whether a camera in the vehicle file is on; if it is off, its pictures are black."""
        entry = next(entry for entry in self._parameters.scenario.vehicles if entry.name == vehicle)
        return camera not in entry.model.cameras or entry.model.cameras[camera].on

    def save(self) -> dict[str, Any]:
        """Return the part of a saved state that belongs to these programs."""
        return {"programs": self._programs.save(), "events": self.events.save()}

    def _change(self, scenario: Scenario) -> None:
        """Apply a scenario that differs from the current one only in its parameters. Raises ValueError."""
        before = self._parameters.scenario
        other_water = scenario.water != before.water
        water = scenario_water(scenario, self._world) if other_water else self._water
        specs = list(self._specs)
        for index, (entry, old) in enumerate(zip(scenario.vehicles, before.vehicles, strict=True)):
            if other_water or entry != old:
                with vehicle_errors_at(scenario, index):
                    specs[index] = vehicle_spec(scenario, entry)
        self._core.change(water, simulation_spec(scenario), specs)
        self._water, self._specs = water, specs
        for index, (entry, vehicle) in enumerate(zip(scenario.vehicles, self._vehicles.values(), strict=True)):
            vehicle.change(entry, specs[index], {})


def _no_estimate(*_: Any) -> NoReturn:
    raise ValueError("estimate: members of a batch have none")
