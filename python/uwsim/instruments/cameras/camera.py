"""Camera: captures pictures of the world at the current time."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arguments import number
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import about_y, about_z, heading_rad, matrix, product
from uwsim.base.sealed import Attached
from uwsim.instruments.cameras.effects import EFFECTS, effects_on
from uwsim.instruments.cameras.frame import CameraInfo, Frame
from uwsim.instruments.cameras.lens import Lens
from uwsim.instruments.cameras.pan_tilt import PanTiltHead
from uwsim.instruments.cameras.shared_scene import SharedScene, Snapshot
from uwsim.scenario.build.camera import core_optics, mount_orientation_xyzw
from uwsim.scenario.spec.camera import LARGEST_SIDE, CameraMount

CLEARANCE_M = 0.3  # minimum height above the ground of a camera that follows a vehicle's heading
Carrier = int | tuple[Floats, Floats]
"""The carrier of a camera: a vehicle's index, or a fixed pose as position (3,) and orientation x, y, z, w (4,)."""


class Camera(Attached):
    """A camera on a vehicle or on the station.

    Its frame is x ahead, y left, z up; `info` holds the intrinsics of the optical frame. Capturing does not advance
    simulated time, and repeated captures at one time give the same picture for any number of threads. A vehicle does
    not appear in pictures from its own cameras, unless the camera follows the vehicle's heading. A camera with a motor
    is panned and tilted with `aim`.
    """

    name: str
    mount: CameraMount
    info: CameraInfo

    def __init__(
        self,
        name: str,
        mount: CameraMount,
        scene: SharedScene,
        carrier: Carrier,
        *,
        owner: str | None = None,
        key: str | None = None,
    ) -> None:
        """Create a camera. owner: its vehicle's name, None for the station. key: its name there, by default `name`."""
        self.name = name
        self.mount = mount
        self._scene = scene
        self._carrier = carrier
        self._owner, self._key = owner, key or name
        self._orientation_xyzw = mount_orientation_xyzw(mount.yaw_pitch_roll_deg)
        self._head = PanTiltHead(name, mount.pan_tilt) if mount.pan_tilt is not None else None
        if self._head is not None:
            scene.heads[name] = self._head
        self._refit(mount)

    def __repr__(self) -> str:
        return f"<Camera '{self.name}', {self.info.width} x {self.info.height} pixels>"

    def change(self, mount: CameraMount) -> None:
        """Replace the mount. Simulator.parameters calls this."""
        if mount != self.mount:
            self._refit(mount)

    def capture(
        self,
        effects: str | Collection[str] = "on",
        *,
        without: Collection[str] = (),
        geometry_only: bool = False,
        radiance: bool = False,
        threads: int | None = None,
        at: Snapshot | None = None,
        dark_below_ground: bool = False,
    ) -> Frame:
        """Return a picture of the world as it is now, or as it was `at` a snapshot.

        effects: "on", "off" (the plain scene, dry and under the open sky), or the names of the effects to apply.
        without: names of effects to omit. geometry_only: whether to omit colour and return only depth, normals, labels
        and classes. radiance: whether to include the radiance. A camera that is off returns a black picture in which
        nothing is hit, as does a camera below the ground if dark_below_ground is set; otherwise, a camera below the
        ground raises ValueError, as do unknown effects. A camera inside another solid shows the inside of that solid.
        """
        off = effects_on(without)
        names = [name for name in effects_on(effects) if name not in off]
        if not self.mount.on or (dark_below_ground and self._is_below_ground(at)):
            return self._dark_frame(at, with_colour=not geometry_only, with_radiance=radiance)
        picture, time_ns, world_from_camera = self._render(
            names, threads, at, geometry_only=geometry_only, keep_radiance=radiance
        )
        return Frame(
            rgb=picture.rgb,
            depth_m=picture.depth_m,
            normals_world=picture.normals_world,
            labels=picture.labels,
            classes=picture.classes,
            pieces=picture.pieces,
            radiance=picture.radiance,
            gain=picture.gain,
            label_names=tuple(self._scene.core.label_names),
            class_names=tuple(self._scene.core.class_names),
            class_of_label=tuple(self._scene.core.classes_by_label),
            info=self.info,
            time_ns=time_ns,
            world_from_camera=world_from_camera,
        )

    def _dark_frame(self, at: Snapshot | None, *, with_colour: bool, with_radiance: bool) -> Frame:
        snapshot = at or self._scene.snapshot(with_lamps=False)
        width, height = self.info.width, self.info.height
        return Frame(
            rgb=np.zeros((height if with_colour else 0, width, 3), np.uint8),
            depth_m=np.full((height, width), np.inf, np.float32),
            normals_world=np.zeros((height, width, 3), np.float32),
            labels=np.zeros((height, width), np.uint16),
            classes=np.zeros((height, width), np.uint8),
            pieces=np.zeros((height if self._scene.has_cover else 0, width), np.uint32),
            radiance=np.zeros((height if with_radiance else 0, width, 3), np.float32),
            gain=1.0,
            label_names=tuple(self._scene.core.label_names),
            class_names=tuple(self._scene.core.class_names),
            class_of_label=tuple(self._scene.core.classes_by_label),
            info=self.info,
            time_ns=snapshot.time_ns,
            world_from_camera=self._pose(snapshot)[2],
        )

    @property
    def world_from_camera(self) -> Floats:
        """The current pose of the camera's frame (x ahead, y left, z up), (4, 4)."""
        return self._pose(self._scene.snapshot(with_lamps=False))[2]

    @property
    def pose(self) -> tuple[Floats, Floats]:
        """The current pose as position (3,) and orientation x, y, z, w (4,) in the world."""
        return self._pose(None)[:2]

    @property
    def aim_rad(self) -> tuple[float, float]:
        """The current pan, positive to port, and tilt, positive down; 0 without a motor."""
        return (0.0, 0.0) if self._head is None else self._head.angles_rad(self._scene.time_ns)

    @property
    def target_rad(self) -> tuple[float, float]:
        """The target pan and tilt, as last passed to `aim`; 0 without a motor."""
        return (0.0, 0.0) if self._head is None else self._head.target_rad

    @property
    def is_aimed(self) -> bool:
        """True once the camera has reached its target pan and tilt; always True without a motor."""
        return self.aim_rad == self.target_rad

    def aim(self, pan_rad: float | None = None, tilt_rad: float | None = None) -> None:
        """Turn to these angles at the motor's rate; None leaves the aim of that axis unchanged.

        Raises ValueError and changes nothing if an angle is beyond the motor's limits or the camera has no motor.
        """
        if self._head is None:
            raise ValueError(f"camera '{self.name}': has no pan_tilt")
        pan, tilt = (
            None if value is None else number(value, f"camera '{self.name}': {axis}", "rad")
            for axis, value in (("pan_rad", pan_rad), ("tilt_rad", tilt_rad))
        )
        self._head.aim(self._scene.time_ns, pan, tilt)
        self._scene.journal.note("aim_camera", camera=self._key, vehicle=self._owner, pan_rad=pan, tilt_rad=tilt)

    def _twin(self) -> Camera:
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    def resized(self, width: int, height: int | None = None) -> Camera:
        """Return this camera with a different size in pixels; by default, the height preserves the aspect ratio.

        The returned camera turns with this one and has the same horizontal field of view. Raises ValueError for sizes
        beyond the limits of a mount.
        """
        for name, pixels in (("width", width), ("height", height or 1)):
            if not 1 <= pixels <= LARGEST_SIDE:
                raise ValueError(f"camera '{self.name}': {name} = {pixels} pixels: must be in [1, {LARGEST_SIDE}]")
        height = height or max(1, round(width * self.mount.height / self.mount.width))
        other = self._twin()
        other._refit(self.mount.resized(width, height))
        return other

    def ray_table(self, *, distort: bool = True, in_water: bool = True) -> NDArray[np.float32]:
        """Return X/Z and Y/Z of the ray through each pixel centre in the optical frame, (H, W, 2) float32.

        distort: whether to distort the rays as the `distortion` effect does. The deflections of `wobble` are not
        included. in_water: whether they are refracted by the mount's flat port, if it has one; their lines then start
        from `ray_offsets_m`.
        """
        return self._lens.core.ray_table(distort, in_water)

    def ray_offsets_m(self) -> NDArray[np.float32]:
        """Return X and Y at which the lines of rays in water meet the plane Z = 0 of the optical frame, (H, W, 2).

        They are 0 without a flat port.
        """
        return self._lens.core.ray_offsets_m()

    def snapshot(self) -> Snapshot:
        """Return the current state, for a later `capture` or one on another thread."""
        return self._scene.snapshot(with_lamps=True)

    def rectified(self) -> Camera:
        """Return this camera as a pinhole with the projection matrix of `info`: without distortion and without a port.

        With the effects "off", the point at depth Z in pixel (u, v) is at X = (u - cx) Z / fx, Y = (v - cy) Z / fy.
        """
        other = self._twin()
        other._fit(self._lens.rectified)
        return other

    def later(self) -> Callable[..., Frame]:
        """Store the current state; return a function that captures it at any later time, on any thread.

        Unlike a snapshot, this also stores the parameters of the camera and of the scene. Below the ground, the picture
        is black. With geometry_rectified=True, the function returns depth, normals, labels and classes of the rectified
        camera instead.
        """
        kept, snapshot = self._twin(), self.snapshot()
        kept._scene = self._scene.kept()

        def capture(*, geometry_rectified: bool = False) -> Frame:
            if not geometry_rectified:
                return kept.capture(at=snapshot, dark_below_ground=True)
            return kept.rectified().capture("off", geometry_only=True, at=snapshot, dark_below_ground=True)

        return capture

    def record_rays(
        self, effects: Collection[str] = EFFECTS, *, geometry_only: bool = False, colours_only: bool = False
    ) -> tuple[bytes, Floats]:
        """Return the ray packets that are cast to render a picture, and their origin (3,), for benchmarks.

        colours_only: whether the picture needs no depth, labels or normals, like those of a batch.
        """
        picture, _, pose = self._render(
            list(effects), 1, None, geometry_only=geometry_only, record=True, colours_only=colours_only
        )
        return picture.packets, pose[:3, 3]

    def _render(
        self, effects: list[str], threads: int | None, at: Snapshot | None, *, geometry_only: bool, **options: bool
    ) -> tuple[_core.Picture, int, Floats]:
        """Return the native picture, its time [ns] and world_from_camera (4, 4)."""
        scene = self._scene
        snapshot = at or scene.snapshot(with_lamps=not geometry_only)
        position, orientation, world_from_camera = self._pose(snapshot)
        picture = scene.core.render(
            self._lens.core,
            core_optics(snapshot.optics),
            position,
            orientation,
            snapshot.time_ns * 1e-9,
            snapshot.time_ns,
            effects,
            snapshot.lamps,
            snapshot.positions_m,
            snapshot.orientations_xyzw,
            self.hidden,
            geometry_only=geometry_only,
            velocity_camera=self.velocity(snapshot),
            threads=scene.threads if threads is None else threads,
            **options,
        )
        return picture, snapshot.time_ns, world_from_camera

    @property
    def scene(self) -> SharedScene:
        """The scene that the camera shares with the simulator's other cameras."""
        return self._scene

    @property
    def carrier(self) -> Carrier:
        """The vehicle or the fixed pose that carries the camera."""
        return self._carrier

    @property
    def hidden(self) -> int | None:
        """The index of the vehicle that does not appear in the pictures, or None."""
        return self._carrier if isinstance(self._carrier, int) and self.mount.follows == "body" else None

    def _refit(self, mount: CameraMount) -> None:
        self._fit(Lens(self.name, mount))

    def _fit(self, lens: Lens) -> None:
        self._lens = lens
        self.__dict__ |= {"mount": lens.mount, "info": lens.info}

    def _is_below_ground(self, at: Snapshot | None) -> bool:
        position = self._pose(at or self._scene.snapshot(with_lamps=False))[0]
        return float(position[2]) < self._scene.ground_m(position)

    def _pose(self, snapshot: Snapshot | None) -> tuple[Floats, Floats, Floats]:
        """Return the camera's position (3,), its orientation x, y, z, w (4,), and both as a matrix (4, 4).

        snapshot: the state to use; None for the current one.
        """
        return self._mounted(*self._carrier_pose(snapshot), self.mounting_xyzw(snapshot))

    def carried(self, position_m: Floats, orientation_xyzw: Floats) -> tuple[Floats, Floats]:
        """Return `pose` as it is with the vehicle that carries the camera at another pose, or (n, 3), (n, 4) at n."""
        mounting = self.mounting_xyzw()
        if position_m.ndim == 1:
            return self._mounted(position_m, self._heading(orientation_xyzw), mounting)[:2]
        carriers = zip(position_m, orientation_xyzw, strict=True)
        poses = [self._mounted(place_m, self._heading(turn), mounting)[:2] for place_m, turn in carriers]
        return np.array([pose[0] for pose in poses]), np.array([pose[1] for pose in poses])

    def _heading(self, orientation_xyzw: Floats) -> Floats:
        return heading_xyzw(orientation_xyzw) if self.mount.follows == "heading" else orientation_xyzw

    def _mounted(
        self, position_m: Floats, orientation_xyzw: Floats, mounting_xyzw: Floats
    ) -> tuple[Floats, Floats, Floats]:
        mount = self.mount.position_m, mounting_xyzw
        position, orientation, world_from_camera = _core.mounted_pose(position_m, orientation_xyzw, *mount)
        if self.mount.follows == "heading":
            position[2] = world_from_camera[2, 3] = max(position[2], self._scene.ground_m(position) + CLEARANCE_M)
        return position, orientation, world_from_camera

    def velocity(self, snapshot: Snapshot) -> Floats:
        """Return the camera's velocity (6,) in its own frame; zero for a camera that is not fixed to a vehicle."""
        if not isinstance(self._carrier, int) or self.mount.follows == "heading":
            return np.zeros(6)
        linear, angular = snapshot.velocities_body[self._carrier].reshape(2, 3)
        (p, q, r), (x, y, z) = angular.tolist(), self.mount.position_m
        here = linear + np.array([q * z - r * y, r * x - p * z, p * y - q * x])  # np.cross takes 20 times as long
        turn = matrix(self.mounting_xyzw(snapshot))
        return np.concatenate([here @ turn, angular @ turn])

    def mounting_xyzw(self, snapshot: Snapshot | None = None) -> Floats:
        """Return the rotation from the camera frame to the carrier frame, x, y, z, w (4,).

        snapshot: the state to use; None for the current one.
        """
        if self._head is None:
            return self._orientation_xyzw
        pan_tilt = self.aim_rad if snapshot is None else snapshot.aims_rad[self.name]
        return product(self._orientation_xyzw, product(about_z(pan_tilt[0]), about_y(pan_tilt[1])))

    def _carrier_pose(self, snapshot: Snapshot | None) -> tuple[Floats, Floats]:
        if not isinstance(self._carrier, int):
            return self._carrier
        if snapshot is None:
            position, orientation = self._scene.vehicle_pose(self._carrier)
        else:
            position, orientation = snapshot.positions_m[self._carrier], snapshot.orientations_xyzw[self._carrier]
        return position, self._heading(orientation)


def heading_xyzw(orientation_xyzw: Floats) -> Floats:
    """Return the rotation about the vertical from east to the heading of a body x axis, x, y, z, w (4,)."""
    return about_z(heading_rad(orientation_xyzw))
