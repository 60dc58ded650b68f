"""Studio: a simulator with a camera, a sonar and targets that is reused from frame to frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.campaigns.datasets.files import annotations_of
from uwsim.campaigns.datasets.poses import Eye, FreeWater, Limits, Viewpoint, draw_viewpoint
from uwsim.campaigns.datasets.spec import OF_CAMERA, DatasetSpec
from uwsim.campaigns.datasets.targets import TERRAIN, Targets
from uwsim.instruments.cameras import Camera, CameraInfo, Frame
from uwsim.instruments.cameras.effects import effects_on
from uwsim.instruments.sonars.imaging import ForwardLooking, SonarImage, look_ahead
from uwsim.instruments.sonars.mounted import ImagingSonar
from uwsim.scenario import load
from uwsim.scenario.build.camera import core_optics
from uwsim.scenario.build.hull import hull_radius_m
from uwsim.scenario.build.solids import obstacle_parts
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.spec.optics import visibility_m
from uwsim.scenario.variation import extremes, level_at
from uwsim.simulator.simulator import Simulator

VALUES, VIEWPOINT, TIME, CONTENT = 0, 1, 2, 3
"""A frame's random draws, each from a separate stream, so that they do not affect each other."""
LATEST_S = 3600.0
"""Upper limit of random times, which determine waves, ripples, particles and noise."""
NEAREST_M = 0.3
CROWD, EMPTY_TRIES = 16, 200
"""The number of poses drawn for a crowded frame, and at most for an empty one."""
SEEN_WELL = 0.6
"""The largest distance to targets, as a fraction of the visibility."""


class Studio:
    """Renders any frame of a dataset from its number alone; the result is the same in every process."""

    def __init__(self, spec: DatasetSpec, threads: int | None = None) -> None:
        """Build the simulator. Raises ValueError for a name that does not exist in the scenario."""
        self.spec = spec
        self.sim = Simulator(spec.scenario, seed=spec.seed, threads=threads)
        self.vehicle = self.sim.rov if spec.vehicle is None else self.sim.vehicles[spec.vehicle]
        self.vehicle.release()
        self._try_variations()
        self.camera = self._chosen_camera()
        self.effects = spec.effects_on
        self.rays = self.camera.ray_table(distort="distortion" in self.effects)
        self._slant = np.sqrt(np.float32(1.0) + (self.rays**2).sum(axis=-1))  # distance at a depth of 1
        self.sonar = self._chosen_sonar() if spec.writes("sonar") else None
        if spec.writes("multibeam"):
            _ = self.vehicle.sonar  # raises ValueError if there is none
        small = self.camera.resized(8, 8).capture(geometry_only=True)
        self.label_names = list(small.label_names)
        terrain = build_terrain(self.sim.scenario.terrain)
        self.parts = [
            (each.name, part) for each in self.sim.scenario.obstacles for part in obstacle_parts(each, terrain)
        ]
        self.class_names = list(small.class_names)
        self.class_of_label = small.class_of_label
        self._drawing: tuple[Targets, Targets | None, Eye] | None = None

    def _try_variations(self) -> None:
        """Raise ValueError unless both ends of each range, and all choices, are allowed."""
        for name, variation in self.spec.vary.items():
            before = self.sim.parameters[name]
            for level in extremes(variation):
                self.sim.parameters[name] = level.value
            self.sim.parameters[name] = before

    def _chosen_camera(self) -> Camera:
        cameras = {**self.sim.cameras, **self.vehicle.cameras}
        if self.spec.camera not in cameras:
            raise ValueError(f"camera = {self.spec.camera!r}: must be one of {', '.join(cameras)}")
        camera = cameras[self.spec.camera]
        return camera if self.spec.size is None else camera.resized(*self.spec.size)

    def _chosen_sonar(self) -> ImagingSonar:
        sonars = {k: s for k, s in self.vehicle.imaging_sonars.items() if isinstance(s.model, ForwardLooking)}
        if not sonars:
            raise ValueError(f"write = sonar: vehicle '{self.vehicle.name}' has no forward-looking sonar")
        name = self.spec.sonar or next(iter(sonars))
        if name not in sonars:
            raise ValueError(f"sonar = {name!r}: must be one of {', '.join(sonars)}")
        return sonars[name]

    @property
    def info(self) -> CameraInfo:
        """The camera intrinsics for its pictures; without the `distortion` effect, those of a plumb_bob with d = 0."""
        info = self.camera.info
        return info if "distortion" in self.effects else replace(info, distortion_model="plumb_bob", d=np.zeros(5))

    @property
    def label_range_m(self) -> float:
        """The maximum distance at which objects are labelled; defaults to the current visibility in the water."""
        if self.spec.label_range_m is not None:
            return self.spec.label_range_m
        return visibility_m(core_optics(self.sim.optics).water) if "attenuation" in self.effects else np.inf

    def vary(self, number: int) -> dict[str, Any]:
        """Draw a frame's parameters, set them and return their values, keyed by name."""
        random = self._random(number, VALUES)
        levels = {name: level_at(variation, random.random()) for name, variation in self.spec.vary.items()}
        if levels:
            self.sim.parameters.update({name: level.value for name, level in levels.items()})
        return {name: level.shown for name, level in levels.items()}

    def time_ns(self, number: int) -> int:
        """Return a random time for a frame."""
        step_ns = round(1e9 * self.sim.step_s)
        return int(self._random(number, TIME).integers(round(LATEST_S / self.sim.step_s))) * step_ns

    def viewpoint(self, number: int) -> Viewpoint:
        """Return a random pose for a frame, in the current water. Raises ValueError if none is found."""
        spec = self.spec
        if self._drawing is None:
            bare = self._targets((TERRAIN,)) if spec.empty_share else None
            self._drawing = self._targets(spec.look_at), bare, self._eye()
        targets, bare, eye = self._drawing
        targets.swim(1e-9 * self.time_ns(number))
        nearest = NEAREST_M + spec.clearance_m
        seen = SEEN_WELL * self.label_range_m
        limits = Limits(
            spec.distance_m or (nearest, max(nearest, seen if np.isfinite(seen) else 20.0)),
            spec.clearance_m, np.radians(spec.pitch_max_deg), np.radians(spec.roll_max_deg),
        )  # fmt: skip
        water, random = FreeWater(self.sim, self.vehicle.name, eye, spec.clearance_m), self._random(number, VIEWPOINT)
        content = self._random(number, CONTENT).random()
        try:
            if bare is not None and content < spec.empty_share:
                return self._emptiest(
                    number, (draw_viewpoint(bare, water, eye, limits, random) for _ in range(EMPTY_TRIES))
                )
            count = CROWD if content < spec.empty_share + spec.crowded_share else 1
            drawn = [draw_viewpoint(targets, water, eye, limits, random) for _ in range(count)]
        except ValueError as error:
            raise ValueError(f"frame {number}: {error}") from None
        return (
            drawn[0] if count == 1 else max(drawn, key=lambda each: len(self._objects(number, each, spec.min_pixels)))
        )

    def _emptiest(self, number: int, drawn: Iterable[Viewpoint]) -> Viewpoint:
        """Return the first viewpoint from which no pixel shows what is looked at. Raises ValueError without one."""
        found = next((each for each in drawn if not self.looked_at(self._objects(number, each, least_pixels=1))), None)
        if found is None:
            what = ", ".join(self.spec.look_at or ["an object"])
            raise ValueError(
                f"empty_share: {what} was in each of {EMPTY_TRIES} pictures of the terrain; change camera, distance_m "
                "or look_at"
            )
        return found

    def looked_at(self, things: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Return the annotations of what the dataset looks at; all of them if it does not state that."""
        wanted = {*(self.spec.look_at or ())} - {TERRAIN}
        names = wanted | {name for name, part in self.parts if part.kind in wanted}
        return [each for each in things if not names or {each["name"], self.class_names[each["category_id"]]} & names]

    def _objects(self, number: int, viewpoint: Viewpoint, least_pixels: int) -> list[dict[str, Any]]:
        """Return the annotations of the picture that a viewpoint would give."""
        try:
            self.place(viewpoint)
        except ValueError:
            return []
        frame = self.camera.capture(
            self.effects, geometry_only=True, at=replace(self.camera.snapshot(), time_ns=self.time_ns(number))
        )
        return self.annotations(frame, least_pixels)

    def annotations(self, frame: Frame, least_pixels: int) -> list[dict[str, Any]]:
        """Return COCO's annotations of the objects that have as many pixels within the range of labels."""
        pieces = frame.pieces if len(frame.pieces) else None
        labels, distances_m = self.labels(frame), self.distances_m(frame)
        return annotations_of(labels, self.class_of_label, self.label_names, distances_m, least_pixels, pieces)

    def labels(self, frame: Frame) -> NDArray[np.uint16]:
        """Return the label of each pixel, (H, W); 0 beyond the range of labels."""
        return np.where(self.distances_m(frame) <= self.label_range_m, frame.labels, 0).astype(np.uint16)

    def place(self, viewpoint: Viewpoint) -> None:
        """Move the vehicle to a viewpoint. Raises ValueError if the position is in the ground or in a solid."""
        self.vehicle.place(viewpoint.position_m, viewpoint.orientation_xyzw)

    def picture(self, time_ns: int) -> Frame:
        """Return the camera's picture as it would be at a given time."""
        only_geometry = not self.spec.writes("rgb", "arrays")
        at = replace(self.camera.snapshot(), time_ns=time_ns)
        return self.camera.capture(self.effects, geometry_only=only_geometry, at=at)

    def ping(self, time_ns: int) -> SonarImage:
        """Return a ping from the forward-looking sonar; the time selects the noise."""
        assert self.sonar is not None
        around = self.sim.around(self.vehicle.name)
        pose, model, name = self.sonar.world_from_sonar, self.sonar.model, self.sonar.stream
        assert isinstance(model, ForwardLooking)
        return look_ahead(around, pose, model, name=name, number=time_ns, with_labels=True)

    def distances_m(self, frame: Frame) -> NDArray[np.float32]:
        """Return distances from the camera along each pixel's ray, (H, W); inf if nothing is hit."""
        return np.asarray(frame.depth_m * self._slant, np.float32)

    def _targets(self, look_at: Sequence[str] | None) -> Targets:
        classes = [self.class_names[k] for k in self.class_of_label]
        by_name = dict(zip(self.label_names, classes, strict=True))
        return Targets(self.sim, self.vehicle.name, by_name, look_at, self.parts)

    def _eye(self) -> Eye:
        mount = self.camera.mount
        if self.spec.camera not in self.vehicle.cameras or mount.follows != "body":
            fixed = ", ".join(k for k, c in self.vehicle.cameras.items() if c.mount.follows == "body")
            raise ValueError(
                f"camera = {self.spec.camera!r}: poses are drawn for cameras that are fixed to the vehicle's hull "
                f"({fixed or 'none'}); give others a track"
            )
        entry = next(e for e in self.sim.scenario.vehicles if e.name == self.vehicle.name)
        rotation = _core.mounted_pose(np.zeros(3), np.array([0, 0, 0, 1.0]), np.zeros(3), self.camera.mounting_xyzw())
        return Eye(np.asarray(mount.position_m), rotation[2][:3, :3], self.rays, hull_radius_m(entry.model))

    def _random(self, number: int, what: int) -> np.random.Generator:
        return np.random.default_rng([self.sim.seed, number, what])


@lru_cache(maxsize=4)
def _kept(spec_json: str, threads: int | None, digest: str) -> Studio:
    studio = Studio(DatasetSpec.model_validate_json(spec_json), threads)
    if scenario_fingerprint(studio.sim.scenario) != digest:
        raise ValueError(f"scenario '{studio.spec.scenario_name}': has changed since the dataset was started")
    return studio


def studio_of(spec: DatasetSpec, threads: int | None, digest: str) -> Studio:
    """Return this process's studio for a dataset and a scenario's fingerprint; the last few are cached."""
    return _kept(spec.model_dump_json(exclude_unset=True), threads, digest)


def digest_of(spec: DatasetSpec) -> str:
    """Return the fingerprint of the scenario as it is now. Raises ScenarioError."""
    return scenario_fingerprint(load(spec.scenario).with_changes(seed=spec.seed))


def require_effects(spec: DatasetSpec) -> None:
    """Raise ValueError for camera options that are unknown, or that change nothing because no picture is written."""
    effects_on(spec.effects)
    effects_on(spec.without)
    if not spec.writes(*OF_CAMERA) and (spec.effects != "on" or spec.without or spec.size is not None):
        raise ValueError("effects, without, size: have no effect unless `write` contains an output of the camera")
