"""A loose body of a simulator: where it is, how it moves, and the forces on it."""

from __future__ import annotations

from uwsim import _core
from uwsim.base.motion import Pose, Velocity
from uwsim.base.named import Named
from uwsim.simulator.forces import Wrench, forces_by_name


class LooseBody:
    """One of a simulator's `objects`, of the scenario's `objects:`. Its origin is the middle of its volume."""

    def __init__(self, simulation: _core.Simulation, index: int, name: str) -> None:
        self._simulation = simulation
        self._index = index
        self.name = name

    def __repr__(self) -> str:
        east, north, up = self.pose.position_world_m.tolist()
        return f"<LooseBody '{self.name}' at ({east:.2f}, {north:.2f}, {up:.2f}) m>"

    @property
    def pose(self) -> Pose:
        """The current pose."""
        state = self._simulation.object_state(self._index)
        return Pose(state.position_world_m, state.orientation_xyzw, state.world_from_body)

    @property
    def velocity(self) -> Velocity:
        """The current velocity."""
        velocity = self._simulation.object_state(self._index).velocity_body
        return Velocity(velocity[:3], velocity[3:])

    @property
    def forces(self) -> Named[Wrench]:
        """The wrenches on the body by name; see Vehicle.forces."""
        return forces_by_name(self._simulation.object_forces(self._index), self.name)

    @property
    def contacts(self) -> list[_core.ContactForce]:
        """The points at which the body was pressed in the last step; see Vehicle.contacts."""
        return self._simulation.object_contacts(self._index)
