"""Compares the light of lamps in water with Mitsuba 3, a path tracer.

tests/python/data/make_mitsuba_radiance.py computed the stored results. Light that is scattered or reflected once is
what `renderer.h` models, so there the two must agree. The stored results of all light are no check, but show what the
model omits: see docs/inside/reality.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.texts.json_text import read_json
from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, along
from uwsim.evidence.validate.pictures import BANDS, NIGHT_DEG, Light, View

RESULTS = Path(__file__).parent / "mitsuba_radiance.json"
DEPTH_M = 300.0
"""The camera's depth: deep enough that no surface and no bed is near."""
HALF_ANGLE_DEG, SOFT_SHARE = 35.0, 0.01
ASYMMETRY = 0.9
"""The asymmetry of particles for lamps, as in kernels/scattering.h."""
TOLERANCE = 0.05


@dataclass(frozen=True)
class Scene:
    """A lamp and boxes about a camera at the origin, which looks along x; lengths in m, z up.

    boxes: (centre, size, albedo). azimuths_deg: the directions in which the radiance is compared, positive to port.
    """

    lamp_m: tuple[float, float, float]
    boxes: tuple[tuple[tuple[float, float, float], tuple[float, float, float], float], ...] = ()
    lamp_azimuth_deg: float = 0.0
    azimuths_deg: tuple[float, ...] = (0.0, 12.0, 20.0)

    @property
    def lamp_axis(self) -> Floats:
        """The direction (3,) in which the lamp shines."""
        azimuth = np.radians(self.lamp_azimuth_deg)
        return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])

    def radiances(self, jerlov: str) -> Floats:
        """Return uwsim's radiance (directions, 3) for a lamp with an intensity of 1 in the unit of irradiance / sr."""
        world = _core.World()
        albedos = {}
        for k, (centre, size, albedo) in enumerate(self.boxes):
            box = trimesh.creation.box(size)
            box.apply_translation(np.add(centre, (0, 0, -DEPTH_M)))
            albedos[world.add_solid(f"box {k}", box.vertices, box.faces)] = albedo
        scene = _core.CameraScene(world, _core.RayScene(world), 0)
        for label, albedo in albedos.items():
            scene.set_appearance(label, "plain", "structure", (albedo,) * 3)
        half = np.radians(HALF_ANGLE_DEG)
        mean_cosine = 0.5 * (np.cos(half) + np.cos(half * (1 - SOFT_SHARE)))
        flux_lm = 1e5 * 2 * np.pi * (1 - mean_cosine)
        turn = Rotation.from_euler("z", self.lamp_azimuth_deg, degrees=True).as_quat()
        lamp = _core.SpotLamp(np.add(self.lamp_m, (0, 0, -DEPTH_M)), turn, flux_lm, half, SOFT_SHARE, (1, 1, 1))
        light = Light(jerlov, NIGHT_DEG)
        names = ["attenuation", "lamps", "backscatter", "shadows"]
        found = [
            View(scene, (0, 0, -DEPTH_M), (azimuth, 0, 0)).ahead(light, names, [lamp]) for azimuth in self.azimuths_deg
        ]
        return np.array(found)


def _wall(distance_m: float) -> tuple[tuple[float, float, float], tuple[float, float, float], float]:
    return (distance_m + 0.5, 0.0, 0.0), (1.0, 40.0, 40.0), 0.5


SCENES = {
    "wall at 3 m, lamp 0.5 m aside": Scene((0.0, 0.5, 0.0), (_wall(3.0),)),
    "wall at 6 m, lamp 0.5 m aside": Scene((0.0, 0.5, 0.0), (_wall(6.0),)),
    "open water, lamp 0.3 m aside": Scene((0.0, 0.3, 0.0)),
    "open water, lamp 2 m aside, turned in": Scene((0.0, -2.0, 0.0), (), 40.0),
    "two materials, lamp 2 m aside": Scene(
        (0.0, -2.0, 0.0),
        (((3.5, 10.0, 0.0), (1.0, 20.0, 40.0), 0.8), ((3.5, -10.0, 0.0), (1.0, 20.0, 40.0), 0.2)),
        25.0,
        (-8.0, 8.0),
    ),
    "box at 1.5 m before open water": Scene((0.0, 0.5, 0.0), (((1.75, 0.0, 0.0), (0.5, 0.5, 0.5), 0.5),)),
}
WATERS = ("II", "3C")


def checks() -> list[Check]:
    """Return a check of each scene and water: the band that differs most, in all directions."""
    return list(_checks(read_json(RESULTS)))


def _checks(kept: dict[str, Any]) -> Iterator[Check]:
    for name, scene in SCENES.items():
        for jerlov in WATERS:
            theirs = np.array(kept["single"][name][jerlov])
            ours = scene.radiances(jerlov)
            band = int(np.argmax(np.abs(ours / theirs - 1.0).max(axis=0)))
            quantity = f"{name}, type {jerlov}, {BANDS[band]}"
            ratio = ours[:, band] / theirs[:, band]
            yield along(f"Mitsuba {kept['mitsuba']}", quantity, np.ones(len(ratio)), ratio, 1.0, TOLERANCE)
