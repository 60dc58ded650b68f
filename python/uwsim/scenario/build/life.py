"""A scenario's life, added to the core's world and to its camera scene."""

from __future__ import annotations

import zlib

import numpy as np

from uwsim import _core
from uwsim.scenario.build.terrain import Terrain
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.life import LifeModel


def add_life(world: _core.World, terrain: Terrain, life: LifeModel) -> None:
    """Add animals to a world whose terrain is set. Raises ScenarioError or ValueError."""
    x, y, z = life.position_m
    bed_m = float(terrain.height_at([[x, y]])[0])
    if np.isnan(bed_m):
        raise ScenarioError(
            f"life '{life.name}' swims about ({x:g}, {y:g}) m: outside the terrain, {terrain.extent_text}"
        )
    if not bed_m + life.clear_m <= z <= -life.clear_m:
        raise ScenarioError(
            f"life '{life.name}' swims about z = {z:g} m: must be between the bed at {bed_m:.4g} m and the surface, "
            f"{life.clear_m:g} m from both"
        )
    random = np.random.default_rng([life.seed, zlib.crc32(life.kind.encode())])
    world.add_school(
        life.name,
        life.count,
        life.shapes(random),
        life.position_m,
        life.round_m,
        life.speed_m_s,
        life.spread_m,
        life.stroke_hz(),
        life.clear_m,
        life.seed,
    )
