"""Obstacles in the world frame, where those that stand on the bed are lowered onto it."""

from __future__ import annotations

import numpy as np

from uwsim.scenario.build.growth import overgrown
from uwsim.scenario.build.solids import bed_below
from uwsim.scenario.build.surface_points import surface_points
from uwsim.scenario.spec.obstacle import Bed, ObstacleModel, Placed, Solid
from uwsim.scenario.spec.part import Part


def obstacle_solid(obstacle: ObstacleModel, terrain: Bed) -> Solid:
    """Return the obstacle in the world frame, with its growth. Raises ScenarioError."""
    solid = grounded(obstacle, terrain).solid(terrain)
    return solid if obstacle.growth is None else overgrown(solid, obstacle.growth)


def obstacle_parts(obstacle: ObstacleModel, terrain: Bed) -> list[Part]:
    """Return the parts of an obstacle in the world. Raises ScenarioError."""
    return grounded(obstacle, terrain).parts(terrain)


def grounded(obstacle: ObstacleModel, terrain: Bed) -> ObstacleModel:
    """Return an obstacle that stands on the bed as one at the coordinates where it stands; any other as it is."""
    return _lowered(obstacle, terrain) if isinstance(obstacle, Placed) and obstacle.on_bed else obstacle


def _lowered(obstacle: Placed, terrain: Bed) -> Placed:
    """Return the obstacle, lowered until it first touches the bed, then raised by the z of its position."""
    x, y, above_m = obstacle.position_m
    afloat = obstacle.model_copy(update={"on_bed": False, "position_m": (x, y, 0.0)})
    solid = afloat.solid(terrain)
    points = np.concatenate([solid.vertices, surface_points(solid.vertices, solid.triangles)])
    clear_m = points[:, 2] - bed_below(terrain, points[:, :2], obstacle.name)
    return afloat.model_copy(update={"position_m": (x, y, above_m - float(clear_m.min()))})
