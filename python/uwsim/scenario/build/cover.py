"""A scenario's cover, life and plumes of bubbles, added to the core's world and to its camera scene."""

from __future__ import annotations

import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.cover_meshes import Mesh, ball, merged
from uwsim.scenario.build.terrain import Terrain
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.cover import ANYWHERE_M, CoverModel, LifeModel
from uwsim.scenario.spec.obstacle import BubblePlume
from uwsim.scenario.spec.scenario import Scenario


def add_cover(world: _core.World, layer: CoverModel) -> None:
    """Add a layer to a world whose solids are complete. Raises ScenarioError or ValueError."""
    near_m, far_m = layer.obstacles_m
    random = np.random.default_rng([layer.seed, zlib.crc32(layer.kind.encode())])
    world.add_cover(
        layer.name,
        layer.meshes(random),
        stance=layer.stance,
        sunk=layer.sunk,
        density_per_m2=layer.density_per_m2,
        size_m=layer.size_m,
        size_exponent=layer.size_exponent,
        depth_m=layer.depth_m,
        slope_rad=tuple(np.radians(layer.slope_deg)),
        from_solids_m=(near_m, far_m if far_m < ANYWHERE_M else np.inf),
        patch_m=layer.patch_m,
        patch_share=layer.patch_share,
        seed=layer.seed,
        solid=layer.is_solid(),
        drag_coefficient=layer.drag_coefficient,
        leans_at_m_s=np.inf if layer.leans_at_m_s is None else layer.leans_at_m_s,
    )


def set_cover_appearance(scene: _core.CameraScene, label: int, layer: CoverModel) -> None:
    """Set material, class and texture of a layer."""
    texture = layer.texture()
    colour = None if texture is not None else layer.material.colour
    kind = layer.surface_class or layer.kind
    scene.set_cover_appearance(label, layer.material.looks, kind, colour, *texture or ())


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


BUBBLE_M = 0.006
"""Diameter where they leave; assumed, between 3 and 10 mm, for which the speed of rise is the same."""
RISE_M_S = 0.23
"""See Plume (cpp/uwsim/world/plume.h)."""
CLUSTERS_PER_S, MOST_CLUSTERS, MOST_BUBBLES = 12.0, 240, 24
PARTS, SHAPES = 4, 4


def plume_names(scenario: Scenario) -> list[str]:
    """Return the names of all plumes: `<obstacle> leak`, from the second on with a number."""
    names = []
    for obstacle in scenario.obstacles:
        for k in range(obstacle.leaks):
            names.append(f"{obstacle.name} leak" + (f" {k + 1}" if k else ""))
    return names


def add_plumes(world: _core.World, terrain: Terrain, scenario: Scenario) -> None:
    """Add the plumes to a world whose life and water are set. Raises ScenarioError."""
    for name, seed, plume in zip(plume_names(scenario), range(1000), _plumes(scenario, terrain), strict=False):
        depth_m = -float(plume.source_m[2])
        if depth_m <= 0:
            x, y, z = plume.source_m
            raise ScenarioError(f"'{name}' is at ({x:.4g}, {y:.4g}) m and z = {z:.4g} m: must be under water")
        way_s = depth_m / RISE_M_S
        count = int(np.clip(CLUSTERS_PER_S * way_s, 20, MOST_CLUSTERS))
        each_m3 = np.pi / 6 * BUBBLE_M**3
        bubbles = plume.rate_l_min / 60_000 * way_s / each_m3 / count
        random = np.random.default_rng([seed, 0x62756262])
        drift = _current_m_s(world.water, [*plume.source_m[:2], -0.5 * depth_m])
        shapes = [_clusters(random, depth_m, (k + 0.5) / PARTS, bubbles) for k in range(PARTS)]
        world.add_plume(name, count, shapes, plume.source_m, 0.0, drift, seed)


def _plumes(scenario: Scenario, terrain: Terrain) -> Iterator[BubblePlume]:
    for obstacle in scenario.obstacles:
        yield from obstacle.plumes(terrain)


def _current_m_s(water: _core.Water, point_m: list[float]) -> NDArray[np.float64]:
    """Return the current (3,) at a point: the mean of the first ten minutes, in which waves cancel."""
    return np.asarray(
        np.mean([water.velocity_m_s([point_m], time_s)[0] for time_s in np.linspace(0, 600, 401)], axis=0)
    )


def _clusters(random: np.random.Generator, depth_m: float, share: float, bubbles: float) -> list[Mesh]:
    """Return clusters at a share of the way up, where the pressure is less and bubbles are larger (Boyle's law)."""
    pressure = (10 + depth_m) / (10 + (1 - share) * depth_m)
    radius_m = 0.5 * BUBBLE_M * pressure ** (1 / 3)
    spread_m = 0.02 + 0.05 * share
    count = int(np.clip(round(bubbles), 3, MOST_BUBBLES))
    if bubbles > MOST_BUBBLES:  # fewer and larger bubbles of the same volume
        radius_m *= (bubbles / MOST_BUBBLES) ** (1 / 3)
    vertices, triangles = ball(0)
    made = []
    for _ in range(SHAPES):
        places = random.normal(0, spread_m, (count, 3))
        sizes = radius_m * random.lognormal(0, 0.25, count)
        flat = np.array([1.0, 1.0, 0.65])  # bubbles of this size are oblate
        made.append(merged([(at + size * flat * vertices, triangles) for at, size in zip(places, sizes, strict=True)]))
    return made
