"""Cameras and lamps: pictures of what is there now, by the light that water lets through."""

from __future__ import annotations

import io
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.atomic_file import write_atomically
from uwsim.scenario.camera_spec import CameraMount, Lamps

Floats = NDArray[np.float64]
EFFECTS: tuple[str, ...] = tuple(_core.effect_names())
"""What may be switched in a picture, by name: attenuation, backscatter, sunlight (Kd and refraction of daylight),
surface (refraction and reflection there), shadows, lamps, caustics, shafts, particles, wobble, distortion, vignetting,
exposure (automatic; 1 without), noise."""

BODY_FROM_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Turns the optical frame (x right, y down, z ahead) into the mount's (x ahead, y left, z up)."""


def effects_on(effects: str | Collection[str]) -> list[str]:
    """Names of the effects that are on, of "on" (all), "off" (none) or names. Raises ValueError."""
    if effects == "on":
        return list(EFFECTS)
    if effects == "off":
        return []
    names = [effects] if isinstance(effects, str) or not isinstance(effects, Iterable) else list(effects)
    for name in names:
        if name not in EFFECTS:
            raise ValueError(f"effects = {name!r}: must be 'on', 'off' or names of {', '.join(EFFECTS)}")
    return names


@dataclass(frozen=True, eq=False)
class CameraInfo:
    """Intrinsics as in sensor_msgs/CameraInfo: d (5,) k1 k2 p1 p2 k3, k (3, 3), r (3, 3), p (3, 4); pixels.

    frame: the optical frame's name, x right, y down, z ahead.
    """

    frame: str
    width: int
    height: int
    distortion_model: str
    d: Floats
    k: Floats
    r: Floats
    p: Floats


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture; arrays are read-only and of one pass.

    rgb: (H, W, 3) uint8, sRGB, (0, W, 3) where geometry alone was taken. depth_m: (H, W) float32 along the optical
    axis, inf for nothing. normals_world: (H, W, 3) float32, of the winding side, 0 for nothing. labels: (H, W) uint16,
    classes: (H, W) uint8, indices into label_names and class_names. Depth, normals, labels and classes are of the first
    solid on each pixel's straight ray, water and its surface being clear; colour follows the light through the surface.
    radiance: (H, W, 3) float32 before exposure, where asked for; irradiance 1 is the sun's outside the air.
    """

    rgb: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    normals_world: NDArray[np.float32]
    labels: NDArray[np.uint16]
    classes: NDArray[np.uint8]
    radiance: NDArray[np.float32]
    gain: float
    label_names: tuple[str, ...]
    class_names: tuple[str, ...]
    info: CameraInfo
    time_ns: int
    world_from_camera: Floats
    rays: dict[str, int]
    stage_s: dict[str, float]

    @property
    def world_from_optical(self) -> Floats:
        """(4, 4) of the optical frame: x right, y down, z ahead."""
        turned = np.array(self.world_from_camera)
        turned[:3, :3] = turned[:3, :3] @ BODY_FROM_OPTICAL
        return turned

    def jpeg(self, quality: int = 90) -> bytes:
        """As a JPEG file. Raises ValueError without colour or for a quality beyond 1..100."""
        import simplejpeg

        if not 1 <= quality <= 100:
            raise ValueError(f"quality = {quality}: must be in [1, 100]")
        return bytes(simplejpeg.encode_jpeg(np.ascontiguousarray(self._coloured()), quality=quality))

    def png(self) -> bytes:
        """As a PNG file. Raises ValueError without colour."""
        from PIL import Image

        stream = io.BytesIO()
        Image.fromarray(self._coloured()).save(stream, "PNG")
        return stream.getvalue()

    def save(self, path: str | Path) -> None:
        """Write a .png, .jpg or .jpeg file, whole or not at all. Raises ValueError for others, OSError."""
        path = Path(path)
        encode: dict[str, Callable[[], bytes]] = {".png": self.png, ".jpg": self.jpeg, ".jpeg": self.jpeg}
        if path.suffix.lower() not in encode:
            raise ValueError(f"path = {path}: must end in .png, .jpg or .jpeg")
        write_atomically(path, encode[path.suffix.lower()]())

    def _coloured(self) -> NDArray[np.uint8]:
        if not len(self.rgb):
            raise ValueError("rgb: this frame holds geometry alone; capture without geometry_only")
        return self.rgb


class Lamp:
    """Lamps on one switch, such as rov.lamps["front"]. Every camera sees their light."""

    def __init__(self, name: str, spec: Lamps) -> None:
        self.name = name
        self.spec = spec
        self._on = False
        self._turns = [mount_turn(spot.yaw_pitch_roll_deg) for spot in spec.spots]

    @property
    def on(self) -> bool:
        """Whether they shine; off at the start."""
        return self._on

    @on.setter
    def on(self, value: bool) -> None:
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"lamp '{self.name}': on = {value!r}: must be True or False")
        self._on = bool(value)

    def lights(self, position_m: Floats, orientation_xyzw: Floats) -> list[_core.LampLight]:
        """As the renderer takes them, from where the vehicle is."""
        spec, half, lights = self.spec, float(np.radians(self.spec.half_angle_deg)), []
        for spot, turn in zip(spec.spots, self._turns, strict=True):
            position, orientation, _ = _core.mounted(position_m, orientation_xyzw, spot.position_m, turn)
            lights.append(_core.LampLight(position, orientation, spec.flux_lm, half, spec.soft_share, spec.colour))
        return lights


def mount_turn(yaw_pitch_roll_deg: Sequence[float]) -> Floats:
    """From what is mounted to what carries it, (4,) as x, y, z, w."""
    turn: Floats = Rotation.from_euler("ZYX", yaw_pitch_roll_deg, degrees=True).as_quat()
    return turn


@dataclass(frozen=True, eq=False)
class Moment:
    """What a picture is taken of: time, poses of all vehicles and, where they matter, the lamps that shine."""

    time_ns: int
    positions_m: Floats
    orientations_xyzw: Floats
    lamps: list[_core.LampLight]


@dataclass(frozen=True, eq=False)
class Stage:
    """What cameras look at.

    scene: made when it is first asked for; optics: as they are now; moment: now, with lamps if told so.
    """

    scene: Callable[[], _core.CameraScene]
    optics: Callable[[], _core.Optics]
    moment: Callable[[bool], Moment]
    threads: int


class Camera:
    """A camera on a vehicle or on the station.

    Its frame is x ahead, y left, z up; `info` gives the optical frame's intrinsics. Taking a picture does not advance
    time, and at one time it is the same picture, whatever the number of threads.
    """

    def __init__(
        self,
        name: str,
        mount: CameraMount,
        stage: Stage,
        carrier: Callable[[Moment], tuple[Floats, Floats]],
        body: int | None,
    ) -> None:
        self.name = name
        self.mount = mount
        self._stage = stage
        self._carrier = carrier
        self._turn = mount_turn(mount.yaw_pitch_roll_deg)
        self._body = body
        half_width = 0.5 * mount.width
        self._focal = half_width / np.tan(np.radians(0.5 * mount.horizontal_fov_deg))
        self.info = self._make_info()
        self._core: _core.Camera | None = None  # its table of rays is made when it is first used

    def capture(
        self,
        effects: str | Collection[str] = "on",
        *,
        without: Collection[str] = (),
        geometry_only: bool = False,
        radiance: bool = False,
        measure: bool = False,
        threads: int | None = None,
    ) -> Frame:
        """Take a picture of now.

        effects: "on", "off" (the plain scene, dry and under the open sky) or the names that are on; without: names
        that are off. geometry_only: depth, normals, labels and classes only. radiance: keep it. measure: fill stage_s.
        Raises ValueError for unknown effects and where the camera is below the ground; inside another solid it sees
        that solid's inner side.
        """
        off = effects_on(without)
        names = [name for name in effects_on(effects) if name not in off]
        picture, moment, pose = self._render(
            names, threads, geometry_only=geometry_only, keep_radiance=radiance, measure=measure
        )
        return self._frame(picture, self._stage.scene(), moment.time_ns, pose)

    def record_rays(self, *, geometry_only: bool = False) -> tuple[bytes, Floats]:
        """For benchmarks: the packets of rays that a picture of now casts through the world, and the eye (3,)."""
        picture, _, pose = self._render(list(EFFECTS), 1, geometry_only=geometry_only, record=True)
        return picture.packets, pose[:3, 3]

    def _render(
        self, effects: list[str], threads: int | None, *, geometry_only: bool, **options: bool
    ) -> tuple[_core.Picture, Moment, Floats]:
        moment = self._stage.moment(not geometry_only)
        position, orientation, pose = _core.mounted(*self._carrier(moment), self.mount.position_m, self._turn)
        if self._core is None:
            self._core = self._make_core()
        picture = self._stage.scene().render(
            self._core,
            self._stage.optics(),
            position,
            orientation,
            moment.time_ns * 1e-9,
            moment.time_ns,
            effects,
            moment.lamps,
            moment.positions_m,
            moment.orientations_xyzw,
            self._body,
            geometry_only=geometry_only,
            threads=self._stage.threads if threads is None else threads,
            **options,
        )
        return picture, moment, pose

    def _frame(self, picture: _core.Picture, scene: _core.CameraScene, time_ns: int, pose: Floats) -> Frame:
        return Frame(
            rgb=picture.rgb,
            depth_m=picture.depth_m,
            normals_world=picture.normals_world,
            labels=picture.labels,
            classes=picture.classes,
            radiance=picture.radiance,
            gain=picture.gain,
            label_names=tuple(scene.label_names),
            class_names=tuple(_core.surface_class_names()),
            info=self.info,
            time_ns=time_ns,
            world_from_camera=pose,
            rays=dict(picture.rays),
            stage_s=dict(picture.stage_s),
        )

    def _make_info(self) -> CameraInfo:
        mount = self.mount
        centre = (0.5 * (mount.width - 1), 0.5 * (mount.height - 1))
        k = np.array([[self._focal, 0, centre[0]], [0, self._focal, centre[1]], [0, 0, 1]])
        p = np.hstack([k, np.zeros((3, 1))])
        d = np.array(mount.distortion)
        return CameraInfo(f"{self.name}_optical", mount.width, mount.height, "plumb_bob", d, k, np.eye(3), p)

    def _make_core(self) -> _core.Camera:
        mount, k = self.mount, self.info.k
        lens = _core.Lens(
            mount.width, mount.height, self._focal, self._focal, float(k[0, 2]), float(k[1, 2]), list(mount.distortion)
        )
        sensor: dict[str, Any] = {
            key: getattr(mount, key) for key in ("exposure", "full_well", "read_noise", "vignetting")
        }
        return _core.Camera(self.name, lens, **sensor, wobble_rad=1e-3 * mount.wobble_mrad)
