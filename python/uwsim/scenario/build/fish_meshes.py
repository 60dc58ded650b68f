"""The shape of a swimming fish: ellipses along a bent line, with a tail and fins, of some two hundred triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.cover_meshes import Mesh, merged, tube

Floats = NDArray[np.float64]

RINGS, SIDES = 12, 8
TAIL = 0.84
"""Where the body ends and the tail fin begins, in lengths from the nose."""


def fish(length_m: float, depth: float, flatness: float, phase: float) -> Mesh:
    """Return a fish that looks along x, z up, its origin in its middle.

    depth: largest height of the body, in lengths. flatness: its width over its height. phase: of the tail's beat, of 1.
    """
    along = TAIL * (0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, RINGS)))
    line = np.column_stack([0.5 - along, np.zeros(RINGS), np.zeros(RINGS)])
    height = np.maximum(_profile(along / TAIL) * 0.5 * depth, 0.012)
    height[0] = 0.004
    vertices, triangles = tube(line, np.ones(RINGS), SIDES)
    ring = np.minimum(np.arange(len(vertices)) // SIDES, RINGS - 1)
    ring[-2:] = 0, RINGS - 1
    turn = 2 * np.pi * (np.arange(len(vertices)) % SIDES) / SIDES
    radial = np.ones(len(vertices))
    radial[-2:] = 0.0
    vertices[:, 0] = line[ring, 0]
    vertices[:, 1] = radial * flatness * height[ring] * np.cos(turn)
    vertices[:, 2] = radial * height[ring] * np.sin(turn)
    parts = [(vertices, triangles), _tail(depth), _back_fin(depth)]
    points, faces = merged(parts)
    share = 0.5 - points[:, 0]
    points[:, 1] += _sway(share, phase)
    return length_m * points, faces


def _sway(share: Floats, phase: float) -> Floats:
    """Return the sideways displacement along a carangiform swimmer, in lengths.

    A wave of one length runs along the body with an amplitude of 0.02 - 0.08 x + 0.16 x^2 (Videler 1993, "Fish
    Swimming", ch. 6).
    """
    amplitude = 0.02 - 0.08 * share + 0.16 * share**2
    return np.asarray(amplitude * np.sin(2 * np.pi * (share - phase)))


def _profile(share: Floats) -> Floats:
    """Return the height of a body, of its largest: full ahead of the middle, and thin at the root of the tail."""
    full = 1.6 * np.sqrt(np.clip(share, 0, 1)) * (1 - share) + 0.9 * share * (1 - share)
    return np.asarray(full / 0.83 + 0.16 * share)


def _tail(depth: float) -> Mesh:
    spread, root = 0.36 * depth + 0.06, 0.02
    points = [(TAIL - 0.03, root), (TAIL - 0.03, -root), (1.0, spread), (0.93, 0.0), (1.0, -spread)]
    vertices = np.array([(0.5 - x, 0.0, z) for x, z in points])
    return vertices, np.array([[0, 2, 3], [0, 3, 1], [1, 3, 4]], np.uint32)


def _back_fin(depth: float) -> Mesh:
    high = 0.5 * depth
    points = [(0.30, 0.9 * high), (0.42, high + 0.09), (0.66, 0.75 * high), (0.52, 0.8 * high)]
    low = [(0.50, -0.8 * high), (0.66, -high - 0.03), (0.70, -0.5 * high)]
    vertices = np.array([(0.5 - x, 0.0, z) for x, z in points + low])
    return vertices, np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]], np.uint32)
