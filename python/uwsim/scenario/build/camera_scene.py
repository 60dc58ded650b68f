"""The core's camera scene, built from a scenario: materials, textures and vehicle hulls."""

from __future__ import annotations

from uwsim import _core
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.read.textures import load_texture
from uwsim.scenario.spec.obstacle import Gate, MeshObstacle, ObstacleSpec, Pipeline
from uwsim.scenario.spec.scenario import Scenario

CLASSES: dict[type, str] = {Pipeline: "pipeline", Gate: "gate"}
"""Surface classes by kind of obstacle; all other kinds are structures."""


def camera_scene(scenario: Scenario, world: _core.World, rays: _core.RayScene) -> _core.CameraScene:
    """Return a scene of the world with its materials and the vehicle hulls. Raises ScenarioError."""
    scene = _core.CameraScene(world, rays, scenario.seed)
    ground = scenario.ground
    scene.set_ground(ground.bed, ground.steep, ground.land)
    label_of = {name: label for label, name in enumerate(world.label_names)}
    for obstacle in scenario.obstacles:
        _set_appearance(scene, label_of[obstacle.name], obstacle)
    if "station" in label_of:
        material = scenario.station.material
        scene.set_appearance(label_of["station"], material.kind, "station", material.colour)
    for vehicle in scenario.vehicles:
        material = vehicle.model.material
        scene.add_vehicle(vehicle.name, *vehicle_hull(vehicle.model), material.kind, material.colour)
    return scene


def _set_appearance(scene: _core.CameraScene, label: int, obstacle: ObstacleSpec) -> None:
    material = obstacle.material
    texture = load_texture(obstacle.file) if isinstance(obstacle, MeshObstacle) and material.colour is None else None
    kind = CLASSES.get(type(obstacle), "structure")
    if texture is None:
        scene.set_appearance(label, material.kind, kind, material.colour)
    else:
        scene.set_appearance(label, material.kind, kind, None, *texture)
