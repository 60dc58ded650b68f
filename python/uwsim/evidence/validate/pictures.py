"""Small pictures of a grey box in water or air, with radiance: what the suites of light measure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.whole_trimesh import trimesh

BANDS = ("red", "green", "blue")
NIGHT_DEG = -6.0
SIDE = 33
"""Width and height of the small pictures [pixels]; odd, so that one pixel looks straight ahead."""


@dataclass(frozen=True)
class Light:
    """A water type and a solar elevation."""

    jerlov: str = "III"
    sun_deg: float = 50.0

    @property
    def water(self) -> _core.WaterOptics:
        """The optical coefficients of the water."""
        return _core.WaterOptics.jerlov(self.jerlov)

    @property
    def optics(self) -> _core.Optics:
        """The native optics, without wind or particles."""
        return _core.Optics(self.water, float(np.radians(self.sun_deg)), 0.7, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class View:
    """A scene and a camera in it. Pitch is positive down; the focal length and side length are in pixels."""

    scene: _core.CameraScene
    position_m: Sequence[float]
    yaw_pitch_roll_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    focal: float = 200.0
    side: int = SIDE

    def picture(self, light: Light, effects: Sequence[str], lamps: Sequence[_core.SpotLamp] = ()) -> _core.Picture:
        """Return a picture from the camera, with radiance."""
        centre = 0.5 * (self.side - 1)
        lens = _core.Lens(self.side, self.side, self.focal, self.focal, centre, centre)
        turn = Rotation.from_euler("ZYX", self.yaw_pitch_roll_deg, degrees=True).as_quat()
        return self.scene.render(
            _core.Camera("check", lens),
            light.optics,
            self.position_m,
            turn,
            0.0,
            0,
            list(effects),
            list(lamps),
            keep_radiance=True,
        )

    def ahead(self, light: Light, effects: Sequence[str], lamps: Sequence[_core.SpotLamp] = ()) -> Floats:
        """Return the radiance (3,) of the central pixel."""
        middle = self.side // 2
        return np.asarray(self.picture(light, effects, lamps).radiance[middle, middle], np.float64)


def box_scene(centre_m: Sequence[float], size_m: Sequence[float]) -> _core.CameraScene:
    """Return a world with one uniformly grey box (albedo 0.5) in open water."""
    world = _core.World()
    box = trimesh.creation.box(size_m)
    box.apply_translation(centre_m)
    label = world.add_solid("box", box.vertices, box.faces)
    scene = _core.CameraScene(world, _core.RayScene(world), 0)
    scene.set_appearance(label, "plain", "structure")
    return scene
