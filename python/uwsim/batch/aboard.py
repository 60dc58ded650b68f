"""One member of a batch as a Simulator, with its vehicles, instruments, faults, failsafes and holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.batch.members import Member
from uwsim.instruments.cameras.shared_scene import SharedScene
from uwsim.instruments.sonars.imaging import Acoustics
from uwsim.scenario import VehicleEntry
from uwsim.scenario.build.craft import ControlSettings
from uwsim.simulator.network import Network
from uwsim.simulator.programs import FailsafeLike
from uwsim.simulator.simulator import Simulator


class MemberAboard(Simulator):
    """A member of a batch with the interface of a Simulator, which is valid until the member is reset.

    It uses one thread. Commands, faults, parameters and restored states apply to the member itself, which the batch
    steps and resets. See uwsim.Simulator for `vehicles`, `events`, `faults` and so on.
    """

    _has_channels = False

    def __init__(
        self,
        core: _core.Simulation,
        world: _core.World,
        scene: _core.RayScene,
        member: Member,
        control: Sequence[ControlSettings],
        like: MemberAboard | None,
    ) -> None:
        """core: the member, whose state is kept. control: the control settings of each vehicle.

        like: a member with which models are shared. Raises ValueError for faults in parts that the member does not
        have.
        """
        self._member, self._control, self._like = member, control, like
        self._assemble(
            member.original, member.scenario, 1, world.with_water(member.water), scene, core,
            None if like is None else like.shared_scene,
        )  # fmt: skip
        self._like = None
        self._parameters.adopt(member.changes, member.scenario)
        self._sensors = [list(vehicle.sensors.values()) for vehicle in self.vehicles.values()]

    def __repr__(self) -> str:
        return f"<MemberAboard: {self.events!r}, {self.faults!r}>"

    def _added(self, index: int, entry: VehicleEntry) -> tuple[_core.VehicleSpec, ControlSettings]:
        return self._member.vehicles[index], self._control[index]

    def _add_objects(self) -> None:
        pass  # the batch has added them

    def _add_tethers(self) -> None:
        pass  # as above

    def _imaging_models(self, index: int, entry: VehicleEntry) -> Mapping[str, Acoustics]:
        if self._like is not None:
            other = self._like.parameters.scenario.vehicles[index]
            if other.model.imaging_sonars == entry.model.imaging_sonars:
                sonars = self._like.vehicles[entry.name].imaging_sonars
                return {name: sonar.model for name, sonar in sonars.items()}
        return super()._imaging_models(index, entry)

    def _joined(self) -> Network | None:
        link = self.scenario.link
        return (
            None
            if link is None or link.modem.kind == "none"
            else Network(self._core, self.scenario, link.modem, self.journal)
        )

    @property
    def failsafes(self) -> Mapping[str, FailsafeLike]:
        """The failsafes, keyed by vehicle; see uwsim.simulator.failures.Failsafe."""
        return {name: rov.failsafe for name, rov in self.vehicles.items() if rov.failsafe is not None}

    @property
    def shared_scene(self) -> SharedScene:
        """The scene of the member's cameras."""
        return self._shared_scene

    def step(self, n: int = 1) -> NoReturn:
        """Raise ValueError: Batch.step advances all members together."""
        raise ValueError(f"step({n}): a member of a batch is advanced by Batch.step")

    def reset(self, seed: int | None = None) -> NoReturn:
        """Raise ValueError: Batch.reset restarts members."""
        raise ValueError(f"reset({seed}): a member of a batch is reset by Batch.reset")

    def acts_within(self, steps: int) -> bool:
        """Return whether anything is due within this many steps."""
        return self.agenda.due_tick < self.tick + steps

    def convert(
        self, vehicle: int, sensor: int, noise: bool, values: NDArray[np.float64], valid: NDArray[np.bool_]
    ) -> None:
        """Convert a sample to the sensor's reading, like Sensor.read.

        `values` (width,) and `valid` (1,) are modified in place.
        """
        instrument = self._sensors[vehicle][sensor]
        if not instrument.on:
            values[...], valid[...] = np.nan, False
        elif noise and instrument.distortion is not None:
            fields = _core.sensor_kind(instrument.kind).fields
            values[...] = instrument.distortion.of_rows(values[None], fields)[0]
