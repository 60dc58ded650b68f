"""Shapes of debris: small triangle meshes with the largest extent 1."""

from __future__ import annotations

import numpy as np

from uwsim.scenario.build.cover_meshes import Mesh, merged, revolved, tube, turned_to, unit

BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def lying_about(random: np.random.Generator) -> list[Mesh]:
    """Return a bottle, a can, a tyre, a plank and a brick, of length 1."""
    bottle = revolved([0, 0.5, 0.55, 0.55, 0.5, 0.2, 0.18, 0.18], [0, 0, 0.05, 1.3, 1.6, 1.9, 2.4, 2.4], 12)
    can = revolved([0, 0.5, 0.52, 0.52, 0.48, 0.0], [0, 0, 0.05, 1.85, 1.9, 1.88], 12)
    around = np.linspace(0, 2 * np.pi, 19)
    tyre = tube(np.stack([np.cos(around), np.sin(around), 0 * around], axis=-1), np.full(19, 0.32), 8, closed=False)
    lying = [turned_to(shape, [1.0, 0.05, random.uniform(0, 0.15)]) for shape in (bottle, can)]
    return [unit(shape) for shape in (*lying, tyre, _box(1.0, 0.16, 0.04), _box(0.24, 0.115, 0.07))]


def _box(*size: float) -> Mesh:
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
             [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip
    return merged([(BOX * size, np.array(faces, np.uint32))])
