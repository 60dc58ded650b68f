"""A loose body of a simulator: where it is, how it moves, and the forces on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NoReturn

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.journal import Journal
from uwsim.base.motion import Pose, Velocity
from uwsim.base.named import Named
from uwsim.scenario.build.arm import link_specs
from uwsim.scenario.spec.scenario import Scenario
from uwsim.simulator.arm import Arm
from uwsim.simulator.forces import WetTriangles, Wrench, forces_by_name, push
from uwsim.simulator.tether import Tether


class LooseBody:
    """One of a simulator's `objects`, of the scenario's `objects:`. Its origin is the middle of its volume.

    joints: those of its links; None without any. Nothing commands them. tether: None without one.
    """

    def __init__(
        self,
        simulation: _core.Simulation,
        index: int,
        name: str,
        journal: Journal,
        joints: Arm | None = None,
        tether: Tether | None = None,
    ) -> None:
        self._simulation = simulation
        self._journal = journal
        self._index = index
        self.name = name
        self.joints = joints
        self.tether = tether

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
    def carried(self) -> bool:
        """True while a vehicle's dropper holds it."""
        return self._simulation.object_loaded(self._index)

    @property
    def forces(self) -> Named[Wrench]:
        """The wrenches on the body by name; see Vehicle.forces."""
        return forces_by_name(self._simulation.object_forces(self._index), self.name)

    @property
    def contacts(self) -> list[_core.ContactForce]:
        """The points at which the body was pressed in the last step; see Vehicle.contacts."""
        return self._simulation.object_contacts(self._index)

    def wet_triangles(self) -> WetTriangles:
        """Return the triangles of the surface that are under water; see Vehicle.wet_triangles."""
        return WetTriangles(*self._simulation.object_wet_surface(self._index))

    def apply_wrench(
        self,
        force_n: Sequence[float] | Floats,
        torque_nm: Sequence[float] | Floats = (0.0, 0.0, 0.0),
        axes: str = "body",
        duration_s: float | None = None,
    ) -> None:
        """Push the body with a force (3,) [N] and a torque (3,) [N m] at its origin; see Vehicle.apply_wrench.

        It is the command `push_object`. Raises ValueError, changing nothing.
        """
        pushed = push(force_n, torque_nm, axes, duration_s)
        self._simulation.apply_object_wrench(self._index, pushed.wrench, pushed.in_world_axes, pushed.duration_s)
        if self._journal.observers:
            self._journal.note("push_object", object=self.name, **pushed.noted)

    def set_winch(self, rate_m_s: float | None = None, tension_n: float | None = None) -> None:
        """Command the winch of the body's tether; see Vehicle.set_winch.

        It is the command `set_object_winch`. Raises ValueError, changing nothing.
        """
        noted = self._own_tether.wind(rate_m_s, tension_n)
        if self._journal.observers:
            self._journal.note("set_object_winch", object=self.name, **noted)

    def cut_tether(self, at_m: float) -> None:
        """Cut the body's tether at this length from its anchor.

        It is the command `cut_object_tether`. Raises ValueError, changing nothing.
        """
        noted = self._own_tether.cut(at_m)
        if self._journal.observers:
            self._journal.note("cut_object_tether", object=self.name, **noted)

    @property
    def _own_tether(self) -> Tether:
        if self.tether is None:
            raise ValueError(f"object '{self.name}': has no tether")
        return self.tether


def loose_bodies(
    simulation: _core.Simulation, scenario: Scenario, journal: Journal, tethers: Mapping[str, Tether]
) -> dict[str, LooseBody]:
    """Return the objects of a simulation, which has them, by name."""
    found = {}
    for index, body in enumerate(scenario.objects):
        links, number = link_specs(body.links or {}), len(scenario.vehicles) + index  # vehicles come first
        joints = Arm(simulation, number, links, _refuse) if links else None
        found[body.name] = LooseBody(simulation, index, body.name, journal, joints, tethers.get(body.name))
    return found


def _refuse(*_: object) -> NoReturn:
    raise ValueError("joints: of an object have no motors")
