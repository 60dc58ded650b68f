"""The cover `seagrass`."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import merged, ribbon, unit
from uwsim.scenario.spec.cover import CoverModel, LeansAt, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec

BLADES = 14


class Seagrass(CoverModel):
    """Tufts of long, narrow leaves; they lean in a current, sway in waves, and brake what moves through them.

    size_m: their height.
    """

    sunk: ClassVar = 0.02
    drag_coefficient: ClassVar = 1.0

    kind: Literal["seagrass"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="leaf")
    leans_at_m_s: LeansAt = 0.12  # assumed

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(merged([_blade(random) for _ in range(BLADES)]), standing=True) for _ in range(5)]


def _blade(random: np.random.Generator) -> Mesh:
    """Return a leaf that bends over towards its tip."""
    turn, bend, length = random.uniform(0, 2 * np.pi), random.uniform(0.05, 0.6), random.uniform(0.5, 1.0)
    out = np.array([np.cos(turn), np.sin(turn), 0.0])
    t = np.linspace(0, 1, 5)[:, None]
    line = np.append(random.normal(0, 0.06, 2), 0) + length * (bend * t**2 * out + (t - 0.25 * bend * t**2) * [0, 0, 1])
    return ribbon(line, np.cross(out, [0, 0, 1]), 0.035 * np.array([0.8, 1, 1, 0.8, 0.1]))
