"""The scene that a simulator's cameras look at: its world with looks, its vehicles where they are, its light."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.cameras import Camera, Floats, Lamp, Moment, Stage
from uwsim.scenario import Scenario, vehicle_hull
from uwsim.scenario.obstacle_spec import Gate, MeshObstacle, ObstacleSpec, Pipeline
from uwsim.scenario.optics_spec import Optics
from uwsim.scenario.textures import load_texture

CLASSES: dict[type, str] = {Pipeline: "pipeline", Gate: "gate"}


class Studio:
    """Makes a simulator's cameras and lamps, and holds its light.

    What cameras need is built when the first picture is taken, so that simulators without pictures do not pay for it.
    """

    def __init__(
        self, scenario: Scenario, world: _core.World, rays: _core.RayScene, core: _core.Simulation, threads: int
    ) -> None:
        self._scenario = scenario
        self._world = world
        self._rays = rays
        self._core = core
        self.optics: Optics = scenario.optics
        self._stage = Stage(lambda: self.scene, self._core_optics, self._moment, threads)
        self._lamps: list[dict[str, Lamp]] = [
            {name: Lamp(name, spec) for name, spec in vehicle.model.lamps.items()} for vehicle in scenario.vehicles
        ]

    def lamps_of(self, vehicle: int) -> dict[str, Lamp]:
        """The vehicle's lamps by the name of their switch."""
        return self._lamps[vehicle]

    def cameras_of(self, vehicle: int) -> dict[str, Camera]:
        """The vehicle's cameras by name."""
        spec = self._scenario.vehicles[vehicle]

        def carrier(moment: Moment) -> tuple[Floats, Floats]:
            return moment.positions_m[vehicle], moment.orientations_xyzw[vehicle]

        return {
            name: Camera(f"{spec.name}/{name}", mount, self._stage, carrier, vehicle)
            for name, mount in spec.model.cameras.items()
        }

    def station_cameras(self) -> dict[str, Camera]:
        """The station's cameras by name."""
        station = self._scenario.station
        turn = Rotation.from_euler("z", station.yaw_deg, degrees=True)
        pose = np.asarray(station.position_m), turn.as_quat()
        fixed: Callable[[Moment], tuple[Floats, Floats]] = lambda moment: pose  # noqa: E731
        return {name: Camera(name, mount, self._stage, fixed, None) for name, mount in station.cameras.items()}

    @cached_property
    def scene(self) -> _core.CameraScene:
        """The world with its looks, and the vehicles' hulls. Raises ScenarioError."""
        scenario = self._scenario
        scene = _core.CameraScene(self._world, self._rays, scenario.seed)
        ground = scenario.ground
        scene.set_ground(ground.bed, ground.steep, ground.land)
        label_of = {name: label for label, name in enumerate(self._world.label_names)}
        for obstacle in scenario.obstacles:
            _set_look(scene, label_of[obstacle.name], obstacle)
        if "station" in label_of:
            material = scenario.station.material
            scene.set_look(label_of["station"], material.kind, "station", material.colour)
        for vehicle in scenario.vehicles:
            material = vehicle.model.material
            scene.add_body(vehicle.name, *vehicle_hull(vehicle.model), material.kind, material.colour)
        return scene

    def _core_optics(self) -> _core.Optics:
        optics = self.optics
        return _core.Optics(
            optics.water(),
            float(np.radians(optics.sun_elevation_deg)),
            float(np.radians(optics.sun_azimuth_deg)),
            optics.wind_m_s,
            float(np.radians(optics.wind_heading_deg)),
            optics.particles_per_m3,
        )

    def _moment(self, lit: bool) -> Moment:
        """All of one time, though others may step the simulation meanwhile."""
        while True:
            version = self._core.version
            states = [self._core.state(k) for k in range(len(self._scenario.vehicles))]
            time_ns = self._core.time_ns
            if self._core.version == version:
                break
        positions = np.array([state.position_world_m for state in states])
        orientations = np.array([state.orientation_xyzw for state in states])
        lamps = [
            light
            for position, orientation, switches in zip(positions, orientations, self._lamps, strict=True)
            for lamp in switches.values()
            if lit and lamp.on
            for light in lamp.lights(position, orientation)
        ]
        return Moment(time_ns, positions, orientations, lamps)


def _set_look(scene: _core.CameraScene, label: int, obstacle: ObstacleSpec) -> None:
    material = obstacle.material
    texture = load_texture(obstacle.file) if isinstance(obstacle, MeshObstacle) and material.colour is None else None
    kind = CLASSES.get(type(obstacle), "structure")
    if texture is None:
        scene.set_look(label, material.kind, kind, material.colour)
    else:
        scene.set_look(label, material.kind, kind, None, *texture)
