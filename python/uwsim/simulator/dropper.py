"""A dropper or launcher of a vehicle: what it holds, and letting go of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from uwsim import _core
from uwsim.base.journal import Journal
from uwsim.base.sealed import Attached
from uwsim.scenario.build.loose_bodies import leaving_along
from uwsim.scenario.spec.arm import Dropper as DropperModel
from uwsim.scenario.spec.loose_body import LooseBody


class Dropper(Attached):
    """A dropper of markers, or a launcher of torpedoes. spec: its place, its magazine, its spring and jet.

    A held body weighs on the vehicle with its mass, its buoyancy and the water that it moves. Once released, it is an
    object like any other: `sim.objects[name]`.
    """

    name: str
    spec: DropperModel

    def __init__(
        self,
        simulation: _core.Simulation,
        vehicle: str,
        name: str,
        model: DropperModel,
        objects: Mapping[str, LooseBody],
        journal: Journal,
        stopped: Callable[[], bool],
    ) -> None:
        """objects: the scenario's, in order, by name. stopped: returns whether the vehicle's all stop is set."""
        self._simulation, self._vehicle, self._journal, self._stopped = simulation, vehicle, journal, stopped
        self._held = {held: list(objects).index(held) for held in model.holds}
        self._along = {held: leaving_along(objects[held]) for held in model.holds}
        self.name = name
        self.spec = model

    def __repr__(self) -> str:
        return f"<Dropper '{self.name}': holds {', '.join(self.loaded) or 'nothing'}>"

    @property
    def loaded(self) -> tuple[str, ...]:
        """The names of the bodies that it holds now, the next to be released first."""
        return tuple(name for name, number in self._held.items() if self._simulation.object_loaded(number))

    def release(self) -> str:
        """Let go of the next body; return its name. It is the command `drop`.

        Raises ValueError, changing nothing, if it is empty, and while all stop is set.
        """
        if self._stopped():
            raise ValueError(f"{self._place}: release: all stop is set")
        if not self.loaded:
            raise ValueError(f"{self._place}: is empty; reload() fills it")
        name = self.loaded[0]
        number = self._held[name]
        self._simulation.release_object(number)
        if self.spec.jet_n > 0:
            thrust = np.concatenate([self.spec.jet_n * self._along[name], np.zeros(3)])
            self._simulation.apply_object_wrench(number, thrust, False, self.spec.jet_s)
        self._note("drop")
        return name

    def reload(self) -> None:
        """Put all of its bodies back, wherever they are, as hands at the pool's edge would. It is the command `reload`.

        The vehicle gets their mass without their momentum.
        """
        for number in self._held.values():
            if not self._simulation.object_loaded(number):
                self._simulation.load_object(number)
                self._simulation.apply_object_wrench(number, [0.0] * 6, False, 0.0)
        self._note("reload")

    @property
    def _place(self) -> str:
        return f"vehicle '{self._vehicle}' dropper '{self.name}'"

    def _note(self, command: str) -> None:
        if self._journal.observers:
            self._journal.note(command, vehicle=self._vehicle, dropper=self.name)
