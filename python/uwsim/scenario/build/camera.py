"""Cameras (lens and image sensor), lamps, optics, and the scene of materials, textures and hulls, as core objects."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base import lens_model
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.build.arm import all_shaped_links, link_mesh
from uwsim.scenario.build.cover import plume_names, set_cover_appearance
from uwsim.scenario.build.hull import hull_placement, vehicle_hull
from uwsim.scenario.build.loose_bodies import object_mesh
from uwsim.scenario.build.solids import growth_texture, obstacle_solid
from uwsim.scenario.build.station import tether_specs
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.read.calibration import CalibrationWarning
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import SPREAD, Texture, load_texture, palette_texture, triangle_means
from uwsim.scenario.spec.arm import Link
from uwsim.scenario.spec.camera import CameraMount, Lamps
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.material import Material, material_kind
from uwsim.scenario.spec.obstacle import BUBBLES, ObstacleModel
from uwsim.scenario.spec.optics import Optics
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.settings import Station
from uwsim.scenario.spec.vehicle import VehicleModel


def core_optics(optics: Optics) -> _core.Optics:
    """Return the core's optics."""
    return _core.Optics(
        optics.water,
        float(np.radians(optics.sun_elevation_deg)),
        float(np.radians(optics.sun_azimuth_deg)),
        optics.wind_m_s,
        float(np.radians(optics.wind_heading_deg)),
        optics.particles_per_m3,
        optics.turbulence_k,
        np.inf if optics.fetch_m is None else optics.fetch_m,
    )


CHASE_LENGTHS = np.array([2.0, 0.8])
"""Distances by which a chase camera is behind and above the hull's centre, in hull diagonals."""


def mount_orientation_xyzw(yaw_pitch_roll_deg: Sequence[float]) -> Floats:
    """Return the rotation from the frame of a mounted part to that of its carrier, (4,) as x, y, z, w."""
    return of_yaw_pitch_roll_deg(yaw_pitch_roll_deg)


def intrinsic_matrix(mount: CameraMount) -> Floats:
    """Return the intrinsic matrix K (3, 3) in pixels: the calibration's, or that of the field of view."""
    if mount.fx is not None:
        return np.array([[mount.fx, 0, mount.cx], [0, mount.fy, mount.cy], [0, 0, 1]])
    focal = 0.5 * mount.width / np.tan(np.radians(0.5 * mount.field_of_view_deg))
    return np.array([[focal, 0, 0.5 * (mount.width - 1)], [0, focal, 0.5 * (mount.height - 1)], [0, 0, 1]])


def core_camera(name: str, mount: CameraMount) -> _core.Camera:
    """Return the core's camera, including its ray table. Raises ValueError.

    A distortion that folds a part of the picture over issues a CalibrationWarning; more than half of it is refused.
    """
    k = intrinsic_matrix(mount)
    lens = _core.Lens(
        mount.width,
        mount.height,
        fx=float(k[0, 0]),
        fy=float(k[1, 1]),
        cx=float(k[0, 2]),
        cy=float(k[1, 2]),
        distortion=list(mount.distortion),
        port=None if mount.port is None else _core.FlatPort(**mount.port.model_dump()),
    )
    try:
        camera = _core.Camera(
            name,
            lens,
            exposure=mount.exposure,
            full_well=mount.full_well,
            read_noise=mount.read_noise,
            vignetting=mount.vignetting,
            wobble_rad=None if mount.wobble_mrad is None else 1e-3 * mount.wobble_mrad,
            shutter_s=1e-3 * mount.shutter_ms,
            readout_s=1e-3 * mount.readout_ms,
        )
    except ValueError as error:
        raise ValueError(
            f"camera '{name}': {error}{'; it folds' + _fold(mount, k) if 'folds' in str(error) else ''}"
        ) from None
    if camera.folded_pixels:
        share = 100.0 * camera.folded_pixels / (mount.width * mount.height)
        text = (
            f"camera '{name}': distortion folds the picture over{_fold(mount, k)}; {share:.2g} % of its pixels continue"
        )
        warnings.warn(
            f"{text} outwards without distortion, which no calibration describes", CalibrationWarning, stacklevel=2
        )
    return camera


def _fold(mount: CameraMount, k: Floats) -> str:
    """Return where the distortion folds the picture over, as part of a message."""
    angle_rad, bent = lens_model.largest_angle(mount.distortion)
    at_pixels, middle = bent * k[0, 0], f"({k[0, 2]:.0f}, {k[1, 2]:.0f})"
    return f" {np.degrees(angle_rad):.1f} deg from the axis, {at_pixels:.0f} pixels from its principal point, {middle}"


def chase_camera(model: VehicleModel) -> CameraMount:
    """Return the default camera that follows the vehicle from behind and above.

    A vehicle's file may define another camera called `chase`.
    """
    vertices_m, _ = vehicle_hull(model)
    low, high = vertices_m.min(axis=0), vertices_m.max(axis=0)
    behind, above = CHASE_LENGTHS * float(np.linalg.norm(high - low))
    centre = 0.5 * (low + high)
    pitch_deg = float(np.degrees(np.arctan2(above, behind)))
    return CameraMount(
        position_m=(float(centre[0] - behind), float(centre[1]), float(centre[2] + above)),
        yaw_pitch_roll_deg=(0.0, pitch_deg, 0.0),
        field_of_view_deg=60.0,
        follows="heading",
    )


def core_lamp(lamps: Lamps, position_m: Floats, orientation_xyzw: Floats) -> _core.SpotLamp:
    """Return a lamp at its pose in the world frame."""
    half_angle_rad = float(np.radians(lamps.half_angle_deg))
    return _core.SpotLamp(position_m, orientation_xyzw, lamps.flux_lm, half_angle_rad, lamps.soft_share, lamps.colour)


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
