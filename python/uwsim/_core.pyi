"""
The native core of uwsim. World ENU, z up, water surface z = 0; SI units; see each docstring for shapes.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import os
import typing

__all__: list[str] = [
    "BodyState",
    "CollisionShape",
    "Craft",
    "CraftParameters",
    "Fluid",
    "MultibeamModel",
    "OccupancyMap",
    "Ping",
    "RayHits",
    "RayScene",
    "SensorSpec",
    "Simulation",
    "SimulationSpec",
    "SolidProperties",
    "SonarSpec",
    "Telemetry",
    "VehicleSpec",
    "Water",
    "World",
    "absorption_db_km",
    "decode_depth_string",
    "encode_depth_string",
    "filter_range",
    "multibeam_model",
    "remove_box",
    "scan_to_points",
    "sensor_kinds",
    "solid_properties",
    "sound_speed_m_s",
    "transform_points",
]

class Water:
    """
    Still water with its surface at z = 0; temperature linear down to bottom_depth_m.
    """
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError that names the field, its value, unit and rule.
        """
    def pressure_pa(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Absolute pressure, p_atm + rho g d.
        """
    def temperature_deg_c(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    @property
    def atmospheric_pressure_pa(self) -> float: ...
    @atmospheric_pressure_pa.setter
    def atmospheric_pressure_pa(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bottom_depth_m(self) -> float: ...
    @bottom_depth_m.setter
    def bottom_depth_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bottom_temperature_deg_c(self) -> float: ...
    @bottom_temperature_deg_c.setter
    def bottom_temperature_deg_c(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def current_world_m_s(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @current_world_m_s.setter
    def current_world_m_s(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...
    @property
    def density_kg_m3(self) -> float: ...
    @density_kg_m3.setter
    def density_kg_m3(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def gravity_m_s2(self) -> float: ...
    @gravity_m_s2.setter
    def gravity_m_s2(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def salinity_psu(self) -> float: ...
    @salinity_psu.setter
    def salinity_psu(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def surface_temperature_deg_c(self) -> float: ...
    @surface_temperature_deg_c.setter
    def surface_temperature_deg_c(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class World:
    """
    The one world that feeds physics and rays. ENU, z up, water at z = 0.
    """

    water: Water
    def __init__(self) -> None: ...
    def add_solid(self, name: str, vertices_world_m: typing.Any, triangles: typing.Any) -> int:
        """
        vertices_world_m: (n, 3) float64; triangles: (m, 3) indices. Returns the label. Raises ValueError.
        """
    def height_at(self, xy_m: typing.Any) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 2) -> (n,) float64 terrain height; NaN outside.
        """
    def set_terrain(
        self, heights_m: typing.Any, spacing_m: typing.SupportsFloat | typing.SupportsIndex, origin_m: typing.Any
    ) -> None:
        """
        heights_m: (ny, nx) float32, z at (x0 + i spacing, y0 + j spacing) is heights_m[j, i]. origin_m: (x0, y0). Raises ValueError on shape, non-finite heights or spacing.
        """
    def surface_mesh(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint32], numpy.typing.NDArray[numpy.uint16]
    ]:
        """
        (vertices_world_m (n, 3) float64, triangles (m, 3) uint32, labels (m,) uint16): terrain and all solids.
        """
    @property
    def label_names(self) -> list[str]:
        """
        Names by label: nothing, terrain, then the solids'.
        """
    @property
    def terrain_extent_m(self) -> tuple[float, float, float, float]:
        """
        (x0, y0, x1, y1) [m]
        """

class RayHits:
    @property
    def labels(self) -> numpy.typing.NDArray[numpy.uint16]:
        """
        (n,) uint16, see World.label_names
        """
    @property
    def normals_world(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (n, 3) float32, unit; zero where nothing was hit
        """
    @property
    def ranges_m(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (n,) float32, inf = nothing within range
        """

class RayScene:
    """
    The world's surfaces for rays (Embree). A snapshot: solids added later are not in it.
    """
    def __init__(self, world: World) -> None: ...
    def cast(
        self, origins_m: typing.Any, directions: typing.Any, max_range_m: typing.SupportsFloat | typing.SupportsIndex
    ) -> RayHits:
        """
        origins_m: (n, 3) or (1, 3); directions: (n, 3), any length but zero. Returns RayHits. Raises ValueError.
        """
    def distance_m(self, points_m: typing.Any) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 3) -> (n,) float64, exact distance to the nearest surface.
        """
    def visible(
        self,
        origin_m: typing.Any,
        points_m: typing.Any,
        tolerance_m: typing.SupportsFloat | typing.SupportsIndex = 0.001,
    ) -> numpy.typing.NDArray[numpy.bool]:
        """
        (n,) bool: no surface lies more than tolerance_m before the point as seen from origin_m (3,).
        """

class BodyState:
    """
    Pose and velocity of a body; six-vectors (linear, angular) in the body frame.
    """
    def __init__(self, position_m: typing.Any, orientation_xyzw: typing.Any, velocity_body: typing.Any) -> None: ...
    @property
    def orientation_xyzw(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"]:
        """
        (4,)
        """
    @property
    def position_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) [m]
        """
    @property
    def velocity_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        (6,) [m/s, rad/s]
        """
    @property
    def world_from_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]:
        """
        (4, 4)
        """

class Fluid:
    """
    The water around a vehicle, for its force models.
    """
    def __init__(self) -> None: ...
    @property
    def current_world_m_s(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @current_world_m_s.setter
    def current_world_m_s(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...
    @property
    def density_kg_m3(self) -> float: ...
    @density_kg_m3.setter
    def density_kg_m3(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def gravity_m_s2(self) -> float: ...
    @gravity_m_s2.setter
    def gravity_m_s2(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class SolidProperties:
    @property
    def centroid_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) [m]
        """
    @property
    def inertia_per_density_m5(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        (3, 3) [m^5], about the centroid; times density gives kg m^2
        """
    @property
    def volume_m3(self) -> float: ...

class CraftParameters:
    """
    A craft's coefficients in Fossen's order: surge, sway, heave, roll, pitch, yaw.
    """
    def __init__(self) -> None: ...
    @property
    def added_mass(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 6]"]:
        """
        (6, 6) M_A [kg, kg m, kg m^2]
        """
    @added_mass.setter
    def added_mass(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 6]"]) -> None: ...
    @property
    def centre_of_mass_body_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) [m]
        """
    @centre_of_mass_body_m.setter
    def centre_of_mass_body_m(
        self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]
    ) -> None: ...
    @property
    def inertia_kg_m2(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        (3, 3), about the centre of mass
        """
    @inertia_kg_m2.setter
    def inertia_kg_m2(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"]) -> None: ...
    @property
    def linear_damping(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 6]"]:
        """
        (6, 6) [N s/m, N m s/rad]
        """
    @linear_damping.setter
    def linear_damping(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 6]"]) -> None: ...
    @property
    def mass_kg(self) -> float: ...
    @mass_kg.setter
    def mass_kg(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def quadratic_damping(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 6]"]:
        """
        (6, 6) [N s^2/m^2, N m s^2/rad^2]
        """
    @quadratic_damping.setter
    def quadratic_damping(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 6]"]) -> None: ...

class Craft:
    """
    A rigid body in fluid: equations of motion after Fossen 2011, ch. 6 and 8.
    """
    def __init__(self, parameters: CraftParameters, vertices_body_m: typing.Any, triangles: typing.Any) -> None:
        """
        vertices_body_m: (n, 3); triangles: (m, 3), closed and winding outward. Raises ValueError.
        """
    def acceleration_body(
        self,
        state: BodyState,
        tau_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        fluid: Fluid,
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        nu' (6,) under the actuators' wrench tau_body (6,).
        """
    def kinetic_energy_j(self, state: BodyState) -> float:
        """
        Of the body and the still water around it.
        """
    def submerged_fraction(self, state: BodyState) -> float:
        """
        0 dry .. 1 fully under water
        """
    @property
    def volume_m3(self) -> float:
        """
        Displaced when submerged.
        """

class MultibeamModel:
    """
    A multibeam's fan, evenly spread about the head's forward axis.
    """
    @property
    def angle_increment_rad(self) -> float: ...
    @property
    def angle_min_rad(self) -> float: ...
    @property
    def beams(self) -> int: ...
    @property
    def dual_swath(self) -> bool: ...
    @property
    def field_of_view_rad(self) -> float: ...
    @property
    def frequency_hz(self) -> float: ...
    @property
    def name(self) -> str: ...
    @property
    def number(self) -> int:
        """
        1..4, as on the wire
        """
    @property
    def range_limit_m(self) -> float:
        """
        The published decoder's limit: above it, no echo.
        """
    @property
    def range_max_m(self) -> float:
        """
        A range at or past it is no echo.
        """

class OccupancyMap:
    """
    octomap::OcTree of the system's OctoMap, about an origin in the world.
    """
    @staticmethod
    def read(path: os.PathLike[str] | str | bytes, origin_world_m: typing.Any) -> OccupancyMap:
        """
        A map from a .bt or .ot file. Raises OSError if it cannot be read, ValueError if it is no sound map of
        OctoMap's. Releases the GIL.
        """
    def __init__(
        self, resolution_m: typing.SupportsFloat | typing.SupportsIndex, origin_world_m: typing.Any
    ) -> None: ...
    def free_voxels(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 3) float64: centres of the finest voxels, world, in Morton order. Releases the GIL.
        """
    def insert_scan(
        self,
        points_world_m: typing.Any,
        origin_world_m: typing.Any,
        max_range_m: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        points_world_m: (n, 3) float32; NaN and inf are skipped. origin_world_m: (3,) float64. Raises ValueError,
        inserting nothing, on shapes, on an origin that is not finite and outside OctoMap's cube. Releases the GIL.
        """
    def occupied_voxels(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 3) float64: centres of the finest voxels, world, in Morton order. Releases the GIL.
        """
    def state_at(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.int8]:
        """
        points_world_m: (n, 3) float64, finite. Returns (n,) int8: 1 occupied, 0 free, -1 unknown. Releases the GIL.
        """
    def statistics(self) -> tuple[int, int, int, int]:
        """
        (occupied voxels, free voxels, nodes, bytes of memory). Releases the GIL.
        """
    def to_bytes(self, format: str) -> bytes:
        """
        The bytes of a 'bt' or 'ot' file. Releases the GIL.
        """
    def write(self, path: os.PathLike[str] | str | bytes, format: str) -> None:
        """
        Atomically. Raises OSError. Releases the GIL.
        """
    @property
    def origin_world_m(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def resolution_m(self) -> float: ...

class SimulationSpec:
    def __init__(self) -> None: ...
    @property
    def mission_time_s(self) -> float: ...
    @mission_time_s.setter
    def mission_time_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def proximity_warning_m(self) -> float: ...
    @proximity_warning_m.setter
    def proximity_warning_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def range_warning_m(self) -> float: ...
    @range_warning_m.setter
    def range_warning_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def seed(self) -> int: ...
    @seed.setter
    def seed(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def station_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @station_world_m.setter
    def station_world_m(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...
    @property
    def step_s(self) -> float: ...
    @step_s.setter
    def step_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class SensorSpec:
    def __init__(
        self,
        name: str,
        kind: str,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        range_max_m: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        noise_std: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    @property
    def kind(self) -> str: ...
    @property
    def name(self) -> str: ...

class SonarSpec:
    def __init__(
        self,
        name: str,
        model: typing.SupportsInt | typing.SupportsIndex,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        elevation_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    @property
    def model(self) -> int: ...
    @property
    def name(self) -> str: ...

class CollisionShape:
    """
    Members:

      HULL

      BOX
    """

    BOX: typing.ClassVar[CollisionShape]
    HULL: typing.ClassVar[CollisionShape]
    __members__: typing.ClassVar[dict[str, CollisionShape]]
    @typing.overload
    def __eq__(self, other: CollisionShape) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: CollisionShape) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class VehicleSpec:
    craft: Craft
    docked: bool
    name: str
    shape: CollisionShape
    def __init__(self) -> None: ...
    def set_start(self, position_m: typing.Any, orientation_xyzw: typing.Any) -> None: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def full_wrench_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        (6,) force and torque at full effort [N, N m]
        """
    @full_wrench_body.setter
    def full_wrench_body(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"]) -> None: ...
    @property
    def restitution(self) -> float: ...
    @restitution.setter
    def restitution(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def sensors(self) -> list[SensorSpec]: ...
    @sensors.setter
    def sensors(self, arg0: collections.abc.Sequence[SensorSpec]) -> None: ...
    @property
    def sonars(self) -> list[SonarSpec]: ...
    @sonars.setter
    def sonars(self, arg0: collections.abc.Sequence[SonarSpec]) -> None: ...

class Ping:
    """
    One multibeam ping. Arrays are read-only, a value a beam.
    """
    @property
    def angles_rad(self) -> numpy.ndarray:
        """
        (beams,) float32, about +z of the sonar, positive to port
        """
    @property
    def incidence_rad(self) -> numpy.ndarray:
        """
        (beams,) float32 in [0, pi/2], NaN = no echo
        """
    @property
    def intensity_db(self) -> numpy.ndarray:
        """
        (beams,) float32, echo level less source level (Lambert, 40 log R, absorption); -inf = no echo
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (beams,) uint16, see World.label_names
        """
    @property
    def model(self) -> int:
        """
        EM 2040 variant 1..4
        """
    @property
    def points_sonar_m(self) -> numpy.ndarray:
        """
        (beams, 3) float32, NaN = no echo
        """
    @property
    def ranges_m(self) -> numpy.ndarray:
        """
        (beams,) float32, inf = no echo
        """
    @property
    def time_ns(self) -> int: ...
    @property
    def valid(self) -> numpy.ndarray:
        """
        (beams,) bool
        """
    @property
    def world_from_sonar(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]:
        """
        (4, 4) float64
        """

class Telemetry:
    """
    The paper's vehicle panel.
    """
    @property
    def acceleration_m_s2(self) -> float: ...
    @property
    def angular_speed_rad_s(self) -> float: ...
    @property
    def battery_percent(self) -> float:
        """
        what is left of the mission time
        """
    @property
    def collision_warning(self) -> bool: ...
    @property
    def depth_m(self) -> float: ...
    @property
    def distance_to_seabed_m(self) -> float:
        """
        straight down; inf over nothing
        """
    @property
    def distance_to_station_m(self) -> float: ...
    @property
    def mission_time_s(self) -> float:
        """
        since the release
        """
    @property
    def pressure_pa(self) -> float:
        """
        absolute
        """
    @property
    def proximity_warning(self) -> bool: ...
    @property
    def range_warning(self) -> bool: ...
    @property
    def speed_m_s(self) -> float: ...
    @property
    def temperature_deg_c(self) -> float: ...
    @property
    def time_s(self) -> float: ...

class Simulation:
    """
    A world with vehicles, advanced by fixed steps; vehicles by index.
    """
    def __init__(self, world: World, scene: RayScene, spec: SimulationSpec) -> None: ...
    def add_vehicle(self, spec: VehicleSpec) -> int:
        """
        Returns the vehicle's index.
        """
    def aim(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        elevation_rad: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Positive is up. Raises ValueError.
        """
    def collisions(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> int:
        """
        How often it came to touch something.
        """
    def effort(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]: ...
    def ping(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> Ping: ...
    def read_sensor(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sensor: typing.SupportsInt | typing.SupportsIndex,
        with_noise: bool = True,
    ) -> dict[str, typing.Any]:
        """
        {field: float or (n,) float64}; repeated at one time it is the same sample.
        """
    def release(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def released(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> bool: ...
    def set_effort(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        effort: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
    ) -> None:
        """
        (6,) surge sway heave roll pitch yaw in [-1, 1]. Raises ValueError.
        """
    def set_state(self, vehicle: typing.SupportsInt | typing.SupportsIndex, state: BodyState) -> None: ...
    def state(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> BodyState: ...
    def step(self, count: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        """
        Fixed steps; releases the GIL, answers Ctrl-C.
        """
    def telemetry(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> Telemetry: ...
    @property
    def tick(self) -> int: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def version(self) -> int:
        """
        Changes whenever something may look different: time, a place, an aim.
        """

def absorption_db_km(
    frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
    temperature_deg_c: typing.SupportsFloat | typing.SupportsIndex,
    salinity_psu: typing.SupportsFloat | typing.SupportsIndex,
    depth_m: typing.SupportsFloat | typing.SupportsIndex,
    acidity_ph: typing.SupportsFloat | typing.SupportsIndex = 8.0,
) -> float:
    """
    Absorption of sound in water [dB/km], Francois and Garrison 1982.
    """

def decode_depth_string(
    text: str,
    beams: typing.SupportsInt | typing.SupportsIndex,
    range_limit_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Ranges of a depthArray text, (beams,) float32; values greater than range_limit_m become inf.
    Raises ValueError that names the beam unless the text is exactly `beams` plain decimals, each followed by a.
    """

def encode_depth_string(ranges_m: typing.Any, range_max_m: typing.SupportsFloat | typing.SupportsIndex) -> str:
    """
    The published depthArray text: C#'s G7 text of each range, each followed by the letter a.
    ranges_m: (n,) float32, in [0, range_max_m], or inf (no echo), which is written as range_max_m.
    Raises ValueError that names the beam on anything else.
    """

def filter_range(
    points_m: typing.Any,
    min_m: typing.SupportsFloat | typing.SupportsIndex,
    max_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    The points whose distance to the origin is in [min_m, max_m]; (n, 3) float32. Raises ValueError. Releases the
    GIL.
    """

def multibeam_model(number: typing.SupportsInt | typing.SupportsIndex) -> MultibeamModel:
    """
    The EM 2040 MKII variant 1..4. Raises ValueError for other numbers.
    """

def remove_box(
    points_m: typing.Any, box_min_m: typing.Any, box_max_m: typing.Any
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::CropBox, negative: the points outside the box, whose faces belong to it; (n, 3) float32. box_*_m: (3,)
    float64. Points that are not finite drop out. Raises ValueError. Releases the GIL.
    """

def scan_to_points(
    ranges_m: typing.Any,
    angle_min_rad: typing.SupportsFloat | typing.SupportsIndex,
    angle_increment_rad: typing.SupportsFloat | typing.SupportsIndex,
    range_min_m: typing.SupportsFloat | typing.SupportsIndex,
    range_max_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    A LaserScan's points in its own frame (x forward, y left), (n, 3) float32, beams in order; as in laser_geometry
    only range_min <= range < range_max counts. ranges_m: (beams,) float32. Raises ValueError. Releases the GIL.
    """

def sensor_kinds() -> list[str]:
    """
    The kinds of sensor that are built in.
    """

def solid_properties(vertices_m: typing.Any, triangles: typing.Any) -> SolidProperties:
    """
    Volume, centroid and inertia of a closed mesh (n, 3), (m, 3). Raises ValueError when it is open or inverted.
    """

def sound_speed_m_s(
    temperature_deg_c: typing.SupportsFloat | typing.SupportsIndex,
    salinity_psu: typing.SupportsFloat | typing.SupportsIndex,
    depth_m: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    Speed of sound in water [m/s], Mackenzie 1981.
    """

def transform_points(
    points_source_m: typing.Any, target_from_source: typing.Any
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::transformPointCloud: (n, 3) float32 in, (n, 3) float32 out. target_from_source: (4, 4) float64, rigid.
    Raises ValueError. Releases the GIL.
    """
