"""A vehicle's arm: its joints' positions, speeds and motors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arguments import read_only
from uwsim.base.short_repr import ShortRepr

Floats = NDArray[np.float64]
ByName = Mapping[str, float]


@dataclass(frozen=True, eq=False, repr=False)
class ArmReading(ShortRepr):
    """An arm at one time, by joint: hinges in rad, rad/s and N m, slides in m, m/s and N.

    names: of the joints that move, which are their links'. positions, speeds (n,): as encoders without errors read
    them. motor_torques (n,): at the joints, at the start of the last step. currents_a (n,): of the motors; NaN where
    the vehicle's file has no torque per ampere.
    """

    names: tuple[str, ...]
    positions: Floats
    speeds: Floats
    motor_torques: Floats
    currents_a: Floats


class Arm:
    """A vehicle's arm, `Vehicle.arm`. Readings are true, not measured.

    names: the joints that move; motors: those with a motor, which accept commands.
    """

    def __init__(
        self,
        simulation: _core.Simulation,
        index: int,
        links: list[_core.ArmLink],
        command: Callable[[ByName | None, ByName | None, ByName | None], None],
    ) -> None:
        self._simulation = simulation
        self._index = index
        self._command = command
        self._moving = [k for k, link in enumerate(links) if link.joint != _core.JointKind.FIXED]
        self.names = tuple(links[k].name for k in self._moving)
        self.motors = tuple(links[k].name for k in self._moving if links[k].strongest > 0)
        self.links = tuple(link.name for link in links)

    def __repr__(self) -> str:
        now = self.read()
        joints = ", ".join(f"{name} {at:.2f}" for name, at in zip(now.names, now.positions, strict=True))
        return f"<Arm: {joints}>"

    def read(self) -> ArmReading:
        """Return the joints' positions, speeds, torques and currents now."""
        now, at = self._simulation.arm(self._index), self._moving
        values = [now.positions, now.speeds, now.motor_torques, now.currents_a]
        return ArmReading(self.names, *(read_only(np.array(each)[at]) for each in values))

    def poses_world(self) -> dict[str, Floats]:
        """Return world_from_link of each link, (4, 4), by name."""
        return dict(zip(self.links, self._simulation.links_world(self._index), strict=True))

    def set_joints(
        self, positions: ByName | None = None, speeds: ByName | None = None, torques: ByName | None = None
    ) -> None:
        """Command joints by name; see Vehicle.set_joints."""
        self._command(positions, speeds, torques)

    def halt(self) -> None:
        """Stop every motor where it is, without a journal entry: for all stop."""
        if self.motors:
            self._simulation.command_joints(self._index, [], [(name, 0.0) for name in self.motors], [])
