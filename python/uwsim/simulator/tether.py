"""A tether of a vehicle or a loose body: its shape, tension and length, and its winch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arguments import number, read_only
from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr
from uwsim.scenario.obstacles.gates import Gate
from uwsim.scenario.obstacles.solids import Cylinder
from uwsim.scenario.spec.scenario import Scenario


@dataclass(frozen=True, eq=False, repr=False)
class TetherReading(ShortRepr):
    """A tether at one time, from its anchor to the vehicle or loose body that has it.

    points_world_m (n + 1, 3): the nodes between its elements. tensions_n (n,): of the elements. anchor_force_world_n,
    vehicle_force_world_n (3,): of the tether on what holds its ends, the second on the vehicle or body, in the last
    step. length_m: out, without load.
    rate_m_s: paid out in the last step. broken_at_m: the length from the anchor at which it has broken, or None.
    is_whole (n,): False for the element that has broken. turns: about each upright obstacle of the scenario, by
    its name (tether_turns.turns_about); 0 once it has broken.
    """

    points_world_m: Floats
    tensions_n: Floats
    anchor_force_world_n: Floats
    vehicle_force_world_n: Floats
    length_m: float
    rate_m_s: float
    broken_at_m: float | None
    is_whole: NDArray[np.bool_]
    turns: Mapping[str, int]

    @property
    def is_tangled(self) -> bool:
        """True if it goes round an upright obstacle, so that it cannot be drawn tight."""
        return any(self.turns.values())

    @property
    def anchor_tension_n(self) -> float:
        """The tension at the anchor or winch."""
        return float(np.linalg.norm(self.anchor_force_world_n))

    @property
    def vehicle_tension_n(self) -> float:
        """The tension at the vehicle or body."""
        return float(np.linalg.norm(self.vehicle_force_world_n))


class Tether:
    """A tether, `Vehicle.tether` or `LooseBody.tether`. Readings are true, not measured."""

    def __init__(
        self, simulation: _core.Simulation, index: int, element_m: float, axes: Mapping[str, tuple[float, float]]
    ) -> None:
        self._simulation = simulation
        self._index = index
        self._element_m = element_m
        self._axes = axes

    def __repr__(self) -> str:
        now = self.read()
        state = "whole" if now.broken_at_m is None else f"broken at {now.broken_at_m:.1f} m"
        return f"<Tether, {now.length_m:.2f} m out, {state}, {now.vehicle_tension_n:.1f} N at the vehicle>"

    def read(self) -> TetherReading:
        """Return its shape, tension and length now."""
        now = self._simulation.tether(self._index)
        broken = None
        if now.broken is not None:  # in the middle of the element; the first one's length differs from the others'
            first_m = now.length_m - (len(now.tensions_n) - 1) * self._element_m
            broken = first_m / 2 if now.broken == 0 else first_m + (now.broken - 0.5) * self._element_m
        points, tensions = np.array(now.points_world_m), np.array(now.tensions_n)
        whole = np.arange(len(tensions)) != (-1 if now.broken is None else now.broken)
        whole.setflags(write=False)
        ends = [read_only(np.array(force)) for force in now.end_forces_n]
        found = turns(points, self._axes) if broken is None else dict.fromkeys(self._axes, 0)
        return TetherReading(
            read_only(points), read_only(tensions), ends[0], ends[1], now.length_m, now.rate_m_s, broken, whole, found
        )

    @property
    def is_broken(self) -> bool:
        """True if it has broken or been cut."""
        return self._simulation.tether(self._index).broken is not None

    def wind(self, rate_m_s: float | None, tension_n: float | None) -> dict[str, float | None]:
        """Command the winch; see Vehicle.set_winch. Returns the command as plain numbers. Raises ValueError."""
        if rate_m_s is not None and tension_n is not None:
            raise ValueError(f"tension_n = {tension_n} N: give either rate_m_s or tension_n")
        rate = None if rate_m_s is None else number(rate_m_s, "rate_m_s", "m/s")
        tension = None if tension_n is None else number(tension_n, "tension_n", "N")
        self._simulation.command_winch(self._index, rate, tension)
        return {"rate_m_s": rate, "tension_n": tension}

    def cut(self, at_m: float) -> dict[str, float]:
        """Cut it; see Vehicle.cut_tether. Returns the command as plain numbers. Raises ValueError."""
        at = number(at_m, "at_m", "m")
        self._simulation.cut_tether(self._index, at)
        return {"at_m": at}

    @property
    def length_m(self) -> float:
        """The length that is out, without load."""
        return float(self._simulation.tether(self._index).length_m)

    def weaken(self, load_n: float) -> None:
        """From now on, break also where the tension exceeds this load; infinite: no longer."""
        self._simulation.weaken_tether(self._index, load_n)


def tethers_of(simulation: _core.Simulation, scenario: Scenario) -> dict[str, Tether]:
    """Return the tethers of a simulation by the name of what has them."""
    axes = upright_axes(scenario) if scenario.tethered else {}
    return {
        one.name: Tether(simulation, number, one.tether.length_m / one.tether.elements, axes)
        for number, one in enumerate(scenario.tethered)
    }


MOST_TILT_DEG = 20.0


def upright_axes(scenario: Scenario) -> dict[str, tuple[float, float]]:
    """Return east and north of the vertical axes that a tether may go round, by name.

    They are those of cylinders within 20 degrees of upright, and of a gate's two posts, `<gate> left` and `right` as
    one flies through it along its yaw.
    """
    axes: dict[str, tuple[float, float]] = {}
    for item in scenario.obstacles:
        if isinstance(item, Cylinder):
            _, pitch, roll = np.radians(item.yaw_pitch_roll_deg)
            if math.cos(pitch) * math.cos(roll) >= math.cos(math.radians(MOST_TILT_DEG)):
                axes[item.name] = (item.position_m[0], item.position_m[1])
        elif isinstance(item, Gate):
            yaw, half_m = math.radians(item.yaw_deg), 0.5 * item.width_m
            for side, sign in (("left", 1.0), ("right", -1.0)):
                at_m = (
                    item.position_m[0] - sign * half_m * math.sin(yaw),
                    item.position_m[1] + sign * half_m * math.cos(yaw),
                )
                axes[f"{item.name} {side}"] = at_m
    return axes


def turns_about(points_world_m: Floats, axis_m: tuple[float, float]) -> int:
    """Return the winding number about a vertical axis of a tether (n, 3) that is closed by the straight line back.

    Seen from above and positive counter-clockwise: 0 if the tether can be drawn tight, and 1 or -1 if the axis holds it
    on the way, or it goes once round. One that passes over the top of an obstacle counts, too.
    """
    offsets = points_world_m[:, :2] - axis_m
    angles = np.arctan2(offsets[:, 1], offsets[:, 0])
    ways = np.append(np.diff(angles), angles[0] - angles[-1])
    return round(float(np.sum((ways + math.pi) % (2 * math.pi) - math.pi)) / (2 * math.pi))


def turns(points_world_m: Floats, axes: Mapping[str, tuple[float, float]]) -> dict[str, int]:
    """Return turns_about each axis, by its name."""
    return {name: turns_about(points_world_m, axis_m) for name, axis_m in axes.items()}
