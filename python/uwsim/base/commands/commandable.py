"""The commands that are methods of a vehicle, defined once for simulated, live and remote vehicles and for missions.

These protocols have method bodies. A class that inherits from a protocol gets its methods, which call the class's
`command`. A class that implements the methods itself, such as the simulated vehicle, conforms without inheriting.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from uwsim.base.arrays import Floats


class Steerable(Protocol):
    """A vehicle that accepts efforts."""

    def set_effort(
        self,
        surge: float = 0.0,
        sway: float = 0.0,
        heave: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
        yaw: float = 0.0,
    ) -> None:
        """Command efforts in [-1, 1] along and about the body axes (REP 103), held until the next command."""
        # `command` is not part of this protocol, since a controller needs only `set_effort`.
        self.command(  # type: ignore[attr-defined]
            "set_effort", surge=surge, sway=sway, heave=heave, roll=roll, pitch=pitch, yaw=yaw
        )


class Commandable(Steerable, Protocol):
    """A vehicle that accepts every command that a real vehicle could.

    A command that raises ValueError has no effect.
    """

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Issue a command by its name in uwsim.base.commands."""

    def release(self) -> None:
        """Leave the station; the mission time starts."""
        self.command("release")

    def undock(self) -> None:
        """Leave the station for open water."""
        self.command("undock")

    def dock(self) -> None:
        """Enter the station's dock from nearby, slowly."""
        self.command("dock")

    def override_failsafe(self) -> None:
        """Take back control of the vehicle from its failsafe."""
        self.command("override_failsafe")

    def all_stop(self, on: bool = True) -> None:
        """Stop the vehicle, overriding all other commands, until called with False."""
        self.command("all_stop", on=on)

    def set_wrench(
        self, force_body_n: Sequence[float] | Floats, torque_body_nm: Sequence[float] | Floats = (0.0, 0.0, 0.0)
    ) -> None:
        """Command the total thruster force (3,) and torque (3,) about the origin, in body axes and for still water."""
        self.command("set_wrench", force_body_n=force_body_n, torque_body_nm=torque_body_nm)

    def set_thrusters(self, commands: Mapping[str, float]) -> None:
        """Command thrusters in [-1, 1] by name; unnamed thrusters stop."""
        self.command("set_thrusters", commands=commands)

    def set_fins(self, angles_rad: Mapping[str, float]) -> None:
        """Command fin deflections by name; unnamed fins return to 0."""
        self.command("set_fins", angles_rad=angles_rad)

    def set_joints(
        self,
        positions: Mapping[str, float] | None = None,
        speeds: Mapping[str, float] | None = None,
        torques: Mapping[str, float] | None = None,
    ) -> None:
        """Command an arm's joints by name: positions [rad or m], speeds, or the motors' torques at the joints."""
        self.command("set_joints", positions=positions, speeds=speeds, torques=torques)

    def set_winch(self, rate_m_s: float | None = None, tension_n: float | None = None) -> None:
        """Command the tether's winch: pay out at a rate, keep a tension, or, without either, hold."""
        self.command("set_winch", rate_m_s=rate_m_s, tension_n=tension_n)


class Placeable(Commandable, Protocol):
    """A simulated vehicle, which can also be placed anywhere and pushed, and its tether cut."""

    def apply_wrench(
        self,
        force_n: Sequence[float] | Floats,
        torque_nm: Sequence[float] | Floats = (0.0, 0.0, 0.0),
        axes: str = "body",
        duration_s: float | None = None,
    ) -> None:
        """Push the vehicle from outside with a force (3,) [N] and a torque (3,) [N m] at its origin."""
        self.command("apply_wrench", force_n=force_n, torque_nm=torque_nm, axes=axes, duration_s=duration_s)

    def cut_tether(self, at_m: float) -> None:
        """Cut the vehicle's tether at this length from its anchor."""
        self.command("cut_tether", at_m=at_m)

    def place(
        self,
        position_world_m: Sequence[float] | Floats,
        orientation_xyzw: Sequence[float] | Floats = (0.0, 0.0, 0.0, 1.0),
        velocity_body: Sequence[float] | Floats = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Move the vehicle to a pose instantly, at rest unless velocity_body (6,) is passed."""
        self.command(
            "place",
            position_world_m=position_world_m,
            orientation_xyzw=orientation_xyzw,
            velocity_body=velocity_body,
        )
