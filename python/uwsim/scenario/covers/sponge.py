"""The cover `sponge`."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import lumps, merged, revolved, turned_to, unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Sponge(CoverModel):
    """Groups of open tubes. size_m: their height."""

    kind: Literal["sponge"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral", colour=(0.62, 0.34, 0.08))

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(merged([_tube(random) for _ in range(random.integers(2, 6))]), standing=True) for _ in range(4)]


def _tube(random: np.random.Generator) -> Mesh:
    """Return a tube that opens at its top, where its wall turns inward."""
    high, wide = random.uniform(0.5, 1.0), random.uniform(0.10, 0.17)
    r = wide * np.array([0.7, 0.85, 1.0, 1.05, 1.0, 0.85, 0.6, 0.55])
    z = high * np.array([0.0, 0.25, 0.5, 0.75, 0.95, 1.0, 0.95, 0.5])
    vertices, triangles = revolved(r, z, 12)
    wave = 1 + 0.09 * lumps(vertices, random, 2.0)
    vertices = vertices * np.stack([wave, wave, np.ones_like(wave)], axis=-1)
    lean = np.append(random.normal(0, 0.25, 2), 1.0)
    return turned_to((vertices, triangles), lean, np.append(random.normal(0, 0.12, 2), 0.0))
