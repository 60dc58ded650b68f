"""The core's camera scene, built from a scenario: materials, textures and vehicle hulls."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.arm import all_shaped_links, link_mesh
from uwsim.scenario.build.bubbles import plume_names
from uwsim.scenario.build.cover import set_cover_appearance
from uwsim.scenario.build.growth import growth_texture
from uwsim.scenario.build.hull import hull_placement, vehicle_hull
from uwsim.scenario.build.loose_bodies import object_mesh
from uwsim.scenario.build.obstacles import obstacle_solid
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.build.tether import tether_specs
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import SPREAD, Texture, load_texture, palette_texture, triangle_means
from uwsim.scenario.spec.arm import Link
from uwsim.scenario.spec.bubble_plume import BUBBLES
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.material import Material, material_kind
from uwsim.scenario.spec.obstacle import ObstacleModel
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.station import Station
from uwsim.scenario.spec.vehicle import VehicleModel


def camera_scene(scenario: Scenario, world: _core.World, rays: _core.RayScene) -> _core.CameraScene:
    """Return a scene of the world with its materials, vehicles, loose bodies and tethers. Raises ScenarioError."""
    scene = _core.CameraScene(world, rays, scenario.seed)
    ground = scenario.ground
    scene.set_ground(*(material_kind(name).looks for name in (ground.bed, ground.steep, ground.land)))
    if scenario.detail == "fine":
        scene.show_detail()
    if ground.ripples_deg is not None:
        scene.set_ripples(math.radians(ground.ripples_deg))
    label_of = {name: label for label, name in enumerate(world.label_names)}
    for obstacle in scenario.obstacles:
        label, texture = label_of[obstacle.name], obstacle_texture(obstacle, scenario)
        _set_appearance(scene, label, obstacle.surface_class, obstacle.surface, texture)
    if "station" in label_of:
        station = scenario.station
        _set_appearance(scene, label_of["station"], "station", station.material, station_texture(station))
    for layer in scenario.cover:
        set_cover_appearance(scene, label_of[layer.name], layer)
    for vehicle in scenario.vehicles:
        material, (vertices, triangles) = vehicle.model.material, vehicle_hull(vehicle.model)
        texture = _hull_texture(vehicle.model, vertices, triangles)
        scene.add_vehicle(vehicle.name, vertices, triangles, material.looks, material.colour, *texture or ())
    for body in scenario.objects:
        shape, mesh = body.shape, object_mesh(scenario, body)
        image, corners, normals = _body_texture(body, len(mesh[1])) or (None, None, None)
        scene.add_vehicle(
            body.name, *mesh, shape.material.looks, shape.material.colour, surface_class=shape.surface_class,
            texture_image=image, texture_corners=corners, texture_normals=normals,
        )  # fmt: skip
    for animals in scenario.life or ():
        scene.add_school(animals.material.looks, animals.surface_class, animals.material.colour)
    for _ in plume_names(scenario):
        scene.add_school(BUBBLES.looks, "bubbles", BUBBLES.colour)
    for carrier, link in all_shaped_links(scenario):
        _add_link(scene, carrier, link)
    for name, spec in tether_specs(scenario).items():
        tube = spec.tube()
        for _ in range(spec.tubes):
            scene.add_vehicle(f"{name} tether", *tube, "paint")
    return scene


def _add_link(scene: _core.CameraScene, carrier: str, link: Link) -> None:
    assert link.shape is not None
    mesh, material, texture = link_mesh(link), link.shape.material, link.shape.texture()
    if texture is not None and len(texture.corners) != len(mesh[1]):  # closing the mesh changed its triangles
        texture = None
    scene.add_vehicle(f"{carrier} {link.shape.name}", *mesh, material.looks, material.colour, *texture or ())


def _hull_texture(
    model: VehicleModel, vertices_m: NDArray[np.float64], triangles: NDArray[np.uint32]
) -> Texture | None:
    """Return the colours of the mesh file, unless the material has one.

    If closing the mesh changed its triangles, each has the mean colour of the file's triangle next to its centre.
    """
    texture = load_texture(model.mesh) if model.material.colour is None else None
    if texture is None or len(texture.corners) == len(triangles):
        return texture
    in_file, own = load_mesh(model.mesh, model.mesh_scale, model.mesh_up, model.mesh_forward or "x")
    factor, shift_m = hull_placement(model)
    sources = np.einsum("kc,mcx->mkx", SPREAD, factor * in_file[own] + shift_m)
    from scipy.spatial import cKDTree  # here, since it takes long to import

    nearest = cKDTree(sources.reshape(-1, 3)).query(vertices_m[triangles].mean(axis=1))[1] // len(SPREAD)
    return palette_texture(triangle_means(texture)[nearest])


def station_texture(station: Station) -> Texture | None:
    """Return the colours of the station's mesh file, unless the material has its own."""
    return load_texture(station.mesh) if station.mesh is not None and station.material.colour is None else None


def obstacle_texture(obstacle: ObstacleModel, scenario: Scenario) -> Texture | None:
    """Return the colours of an obstacle, or of what has grown on it."""
    growth = obstacle.growth
    if growth is None or not growth.age_years:
        return obstacle.texture()
    return growth_texture(obstacle_solid(obstacle, build_terrain(scenario.terrain)), growth)


def _body_texture(body: LooseBody, triangles: int) -> Texture | None:
    """Return the colours of a body's shape, unless closing its mesh changed its triangles."""
    texture = body.shape.texture()
    return texture if texture is not None and len(texture.corners) == triangles else None


def _set_appearance(
    scene: _core.CameraScene, label: int, kind: str, material: Material, texture: Texture | None
) -> None:
    """Set the material of a solid; a texture overrides its colour."""
    colour = None if texture is not None else material.colour
    scene.set_appearance(label, material.looks, kind, colour, *texture or ())
