"""A sonar's surroundings: the surfaces and water around it at one time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from uwsim import _core


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A snapshot from `Simulator.around`, for imaging sonars and depth maps.

    scene: the world and the other vehicles. strengths_db: Lambert strength of each surface's material, by
    Simulator.label_names. materials: how each surface scatters by angle and how it reflects, by the same names.
    """

    scene: _core.RayScene
    world: _core.World
    strengths_db: Mapping[str, float]
    seed: int
    threads: int
    time_ns: int
    materials: Mapping[str, _core.BottomMaterial] = field(default_factory=dict)
