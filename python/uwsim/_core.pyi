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
    "AcousticMultibeam",
    "AcousticSpec",
    "ActuatorsSpec",
    "BodyState",
    "BottomMaterial",
    "Camera",
    "CameraScene",
    "CollisionShape",
    "Craft",
    "CraftParameters",
    "Current",
    "DepthCamera",
    "Detection",
    "FinParameters",
    "ForwardLookingModel",
    "ImagingAcoustics",
    "InstructionSet",
    "LampLight",
    "Lens",
    "MapEngine",
    "MapOptions",
    "MultibeamModel",
    "NoiseSpec",
    "OccupancyMap",
    "Optics",
    "PhysicsPing",
    "Picture",
    "Ping",
    "PingBatch",
    "RayHits",
    "RayScene",
    "RoundShape",
    "RowReduction",
    "SensorKind",
    "SensorParameter",
    "SensorReading",
    "SensorSpec",
    "SideScanModel",
    "Simulation",
    "SimulationSpec",
    "SingleBeamModel",
    "SolidProperties",
    "SonarFigures",
    "SonarSpec",
    "SoundSpeedProfile",
    "Telemetry",
    "ThrustCurve",
    "ThrusterParameters",
    "VehicleSpec",
    "Water",
    "WaterOptics",
    "WaterProfile",
    "Waves",
    "World",
    "absorption_db_km",
    "decode_depth_string",
    "depth_image",
    "depth_image_ranges",
    "detection_probability",
    "effect_names",
    "encode_depth_string",
    "filter_range",
    "forward_look",
    "ground_plane",
    "jerlov_types",
    "material_names",
    "mounted",
    "multibeam_model",
    "nadir_area_m2",
    "nadir_snr_db",
    "pass_through",
    "refracted",
    "register_cloud",
    "remove_box",
    "remove_outliers",
    "scan_to_points",
    "sea_water_density_kg_m3",
    "sensor_kind",
    "sensor_kinds",
    "side_scan",
    "single_beam",
    "solid_properties",
    "sound_speed_m_s",
    "sound_speed_profile",
    "soundings",
    "surface_class_names",
    "transform_points",
    "voxel_grid",
]

class SoundSpeedProfile:
    """
    Speed of sound by depth: linear between levels, constant above and below them.
    """
    @staticmethod
    def even(speed_m_s: typing.SupportsFloat | typing.SupportsIndex) -> SoundSpeedProfile:
        """
        One speed everywhere: straight rays.
        """
    def __init__(self, depths_m: typing.Any, speeds_m_s: typing.Any) -> None:
        """
        Each (n,), depths rising. Raises ValueError that names the level.
        """
    def at(self, depth_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Speed [m/s] at a depth [m].
        """

class SonarFigures:
    """
    What an active sonar sends, hears and decides by. Levels re 1 uPa (at 1 m).
    """
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError that names the field.
        """
    def range_cell_m(self, sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    @property
    def bandwidth_hz(self) -> float: ...
    @bandwidth_hz.setter
    def bandwidth_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def beam_width_across_rad(self) -> float:
        """
        -3 dB, one way: of a receiving beam, within the fan's plane
        """
    @beam_width_across_rad.setter
    def beam_width_across_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def beam_width_along_rad(self) -> float:
        """
        -3 dB, one way: of the transmitter, across the fan's plane
        """
    @beam_width_along_rad.setter
    def beam_width_along_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def detection_threshold_db(self) -> float:
        """
        The signal-to-noise ratio that is detected half of the time.
        """
    @detection_threshold_db.setter
    def detection_threshold_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def directivity_index_db(self) -> float: ...
    @directivity_index_db.setter
    def directivity_index_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def figure_db(self) -> float:
        """
        SL + processing gain + DI - NL
        """
    @property
    def frequency_hz(self) -> float: ...
    @frequency_hz.setter
    def frequency_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def noise_level_db(self) -> float:
        """
        In the receiver's band.
        """
    @noise_level_db.setter
    def noise_level_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def processing_gain_db(self) -> float:
        """
        10 log10 (bandwidth x length)
        """
    @property
    def pulse_length_s(self) -> float: ...
    @pulse_length_s.setter
    def pulse_length_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def source_level_db(self) -> float: ...
    @source_level_db.setter
    def source_level_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class BottomMaterial:
    """
    What a bottom gives back.
    """
    def __init__(
        self,
        strength_db: typing.SupportsFloat | typing.SupportsIndex = -30.0,
        relief: typing.SupportsFloat | typing.SupportsIndex = 0.1,
    ) -> None: ...
    @property
    def relief(self) -> float:
        """
        rms slope of its relief across a footprint
        """
    @property
    def strength_db(self) -> float:
        """
        Of a square metre at normal incidence; Lambert's law.
        """

class Waves:
    """
    Linear waves on water of one depth, stretched to their own surface (Airy; Wheeler 1970).
    """
    @staticmethod
    def airy(
        amplitude_m: typing.SupportsFloat | typing.SupportsIndex,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
        heading_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        phase_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        depth_m: typing.SupportsFloat | typing.SupportsIndex = ...,
        gravity_m_s2: typing.SupportsFloat | typing.SupportsIndex = 9.80665,
    ) -> Waves:
        """
        One wave that runs towards heading_rad (from east, counter-clockwise). Raises ValueError.
        """
    @staticmethod
    def jonswap(
        significant_height_m: typing.SupportsFloat | typing.SupportsIndex,
        peak_period_s: typing.SupportsFloat | typing.SupportsIndex,
        peak_enhancement: typing.SupportsFloat | typing.SupportsIndex = 3.3,
        heading_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        spreading_exponent: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        component_count: typing.SupportsInt | typing.SupportsIndex = 64,
        seed: typing.SupportsInt | typing.SupportsIndex = 0,
        depth_m: typing.SupportsFloat | typing.SupportsIndex = ...,
        gravity_m_s2: typing.SupportsFloat | typing.SupportsIndex = 9.80665,
    ) -> Waves:
        """
        A sea of component_count waves. Raises ValueError.
        """
    @property
    def bound_m(self) -> float:
        """
        No crest is higher, no trough deeper.
        """
    @property
    def depth_m(self) -> float: ...
    @property
    def significant_height_m(self) -> float:
        """
        4 sqrt(m0)
        """

class Current:
    """
    A current: a function of place and time. All raise ValueError.
    """
    @staticmethod
    def gridded(x_m: typing.Any, y_m: typing.Any, z_m: typing.Any, velocity_m_s: typing.Any) -> Current:
        """
        A steady field, velocity_m_s (nz, ny, nx, 3) on rising axes: trilinear, held beyond its edges.
        """
    @staticmethod
    def gusty(
        sigma_m_s: typing.Any,
        correlation_time_s: typing.SupportsFloat | typing.SupportsIndex,
        seed: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> Current:
        """
        Gauss-Markov, of standard deviation sigma_m_s (3,) about no mean.
        """
    @staticmethod
    def layered(depth_m: typing.Any, velocity_m_s: typing.Any) -> Current:
        """
        depth_m: (n,) rising; velocity_m_s: (n, 3). Linear between.
        """
    @staticmethod
    def tidal(
        amplitude_m_s: typing.Any,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
        phase_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> Current:
        """
        amplitude_m_s (3,) times sin(2 pi t / period_s + phase_rad).
        """
    def velocity_m_s(
        self, point_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,)
        """

class WaterProfile:
    """
    Temperature, salinity, density and sound speed, linear in depth between levels.
    """
    def __init__(
        self,
        depth_m: typing.Any,
        temperature_deg_c: typing.Any,
        salinity_psu: typing.Any,
        density_kg_m3: typing.Any,
        sound_speed_m_s: typing.Any = None,
    ) -> None:
        """
        Each (n,), depths rising; without sound_speed_m_s it follows from the others. Raises ValueError.
        """

class Water:
    """
    The water: still, even and with one steady current, unless waves, a profile or currents are set.
    """
    def __init__(self) -> None: ...
    def add_current(self, current: Current) -> None:
        """
        Adds to current_world_m_s and to those added before.
        """
    def check(self) -> None:
        """
        Raises ValueError that names the field, its value, unit and rule.
        """
    def density_at_kg_m3(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        At rest.
        """
    def pressure_at_pa(
        self, points_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 3) -> (n,) absolute, under the waves of the moment.
        """
    def pressure_pa(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Absolute, of the water at rest: p_atm + the integral of rho g.
        """
    def salinity_at_psu(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    def sound_speed_m_s(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        As the profile gives it, else by temperature, salinity and depth (Mackenzie 1981).
        """
    def surface_height_m(
        self, xy_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 2) -> (n,)
        """
    def temperature_deg_c(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    def velocity_m_s(
        self, points_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 3) -> (n, 3), current and waves together.
        """
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
    def profile(self) -> WaterProfile | None:
        """
        None: one density and salinity, temperature linear down to bottom_depth_m
        """
    @profile.setter
    def profile(self, arg1: WaterProfile | None) -> None: ...
    @property
    def salinity_psu(self) -> float: ...
    @salinity_psu.setter
    def salinity_psu(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def surface_temperature_deg_c(self) -> float: ...
    @surface_temperature_deg_c.setter
    def surface_temperature_deg_c(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def waves(self) -> Waves | None:
        """
        None: still
        """
    @waves.setter
    def waves(self, arg1: Waves | None) -> None: ...

class RoundShape:
    """
    A sphere, or a straight piece of round pipe: what rays meet without facets.
    """
    @staticmethod
    def cylinder(
        start_world_m: typing.Any, end_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex
    ) -> RoundShape:
        """
        Between two points (3,) on its axis, with flat caps. Raises ValueError.
        """
    @staticmethod
    def pipe(line_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex) -> list[RoundShape]:
        """
        Pieces along a line (n, 3), capped at both ends, mitred where it bends. Raises ValueError.
        """
    @staticmethod
    def sphere(centre_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex) -> RoundShape:
        """
        centre_world_m: (3,). Raises ValueError.
        """
    @property
    def radius_m(self) -> float: ...

class World:
    """
    The one world that feeds physics and rays. ENU, z up, water at z = 0.
    """

    water: Water
    def __init__(self) -> None: ...
    def add_solid(
        self,
        name: str,
        vertices_world_m: typing.Any,
        triangles: typing.Any,
        shapes: collections.abc.Sequence[RoundShape] = [],
    ) -> int:
        """
        vertices_world_m: (n, 3) float64; triangles: (m, 3) indices. shapes: what rays meet instead of the mesh,
        which then stands for contacts and the true surface. Returns the label. Raises ValueError.
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
    def solid_around(
        self, point_world_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]
    ) -> str | None:
        """
        (3,) -> the name of a closed solid that the point is inside of, or None.
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
        water: Water,
        time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        nu' (6,) under the actuators' wrench tau_body (6,).
        """
    def kinetic_energy_j(self, state: BodyState) -> float:
        """
        Of the body and the still water around it.
        """
    def submerged_fraction(
        self, state: BodyState, water: Water | None = None, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> float:
        """
        0 dry .. 1 fully under water; without water, under z = 0.
        """
    @property
    def volume_m3(self) -> float:
        """
        Displaced when submerged.
        """

class ThrustCurve:
    """
    Thrust in still water against a command in [-1, 1], linear between points.
    """
    def __init__(
        self,
        commands: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        thrusts_n: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        path: str = "thrust_curve",
    ) -> None:
        """
        Raises ValueError unless commands increase, thrusts never fall and command 0 gives 0 N.
        """
    def command(self, thrust_n: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        A command that gives this thrust.
        """
    def thrust_n(self, command: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    @property
    def highest_n(self) -> float: ...
    @property
    def lowest_n(self) -> float: ...

class ThrusterParameters:
    """
    A propeller with its motor, body frame.
    """
    def __init__(self, name: str, position_body_m: typing.Any, axis_body: typing.Any, curve: ThrustCurve) -> None: ...
    @property
    def axis_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) unit, where a positive thrust pushes
        """
    @property
    def bollard_coefficient(self) -> float:
        """
        K_T at rest
        """
    @bollard_coefficient.setter
    def bollard_coefficient(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def curve(self) -> ThrustCurve: ...
    @property
    def diameter_m(self) -> float: ...
    @diameter_m.setter
    def diameter_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def position_body_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) [m], hub
        """
    @property
    def spin(self) -> int:
        """
        1 right-handed about the axis, -1 left-handed
        """
    @spin.setter
    def spin(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def time_constant_s(self) -> float:
        """
        of the thrust; 0 follows at once
        """
    @time_constant_s.setter
    def time_constant_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def torque_per_thrust_m(self) -> float:
        """
        k_q [m]
        """
    @torque_per_thrust_m.setter
    def torque_per_thrust_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def zero_thrust_advance_ratio(self) -> float:
        """
        inf: no loss
        """
    @zero_thrust_advance_ratio.setter
    def zero_thrust_advance_ratio(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class FinParameters:
    """
    A lifting surface, body frame.
    """

    stalls: bool
    def __init__(
        self,
        name: str,
        position_body_m: typing.Any,
        span_body: typing.Any,
        area_m2: typing.SupportsFloat | typing.SupportsIndex,
        aspect_ratio: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    def lift_slope(self) -> float:
        """
        dC_L / d alpha at no lift [1/rad].
        """
    @property
    def area_m2(self) -> float: ...
    @property
    def aspect_ratio(self) -> float: ...
    @property
    def deflection_max_rad(self) -> float:
        """
        0: fixed
        """
    @deflection_max_rad.setter
    def deflection_max_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def efficiency(self) -> float:
        """
        Oswald's
        """
    @efficiency.setter
    def efficiency(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def parasitic_drag(self) -> float: ...
    @parasitic_drag.setter
    def parasitic_drag(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def position_body_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) [m], centre of pressure
        """
    @property
    def rate_max_rad_s(self) -> float: ...
    @rate_max_rad_s.setter
    def rate_max_rad_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def span_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) unit; a deflection turns about it, right-handed
        """
    @property
    def stall_angle_rad(self) -> float: ...
    @stall_angle_rad.setter
    def stall_angle_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def stall_sharpness_rad(self) -> float: ...
    @stall_sharpness_rad.setter
    def stall_sharpness_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class ActuatorsSpec:
    """
    What drives and steers a vehicle.
    """
    def __init__(self) -> None: ...
    @property
    def fins(self) -> list[FinParameters]: ...
    @fins.setter
    def fins(self, arg0: collections.abc.Sequence[FinParameters]) -> None: ...
    @property
    def full_wrench_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        (6,) force and torque straight along and about the axes at full effort [N, N m]
        """
    @full_wrench_body.setter
    def full_wrench_body(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"]) -> None: ...
    @property
    def thrusters(self) -> list[ThrusterParameters]: ...
    @thrusters.setter
    def thrusters(self, arg0: collections.abc.Sequence[ThrusterParameters]) -> None: ...

class MultibeamModel:
    """
    A multibeam's fan, evenly spread about the head's forward axis.
    """
    def __init__(
        self,
        *,
        name: str,
        beams: typing.SupportsInt | typing.SupportsIndex,
        field_of_view_rad: typing.SupportsFloat | typing.SupportsIndex,
        range_max_m: typing.SupportsFloat | typing.SupportsIndex,
        frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
        range_limit_m: typing.SupportsFloat | typing.SupportsIndex | None = None,
        number: typing.SupportsInt | typing.SupportsIndex = 0,
        dual_swath: bool = False,
        ping_rate_max_hz: typing.SupportsFloat | typing.SupportsIndex = 50.0,
        tilt_rate_rad_s: typing.SupportsFloat | typing.SupportsIndex = 0.0872665,
    ) -> None:
        """
        Raises ValueError that names the field.
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
        1..4, as on the wire; 0: not of the wire
        """
    @property
    def ping_rate_max_hz(self) -> float:
        """
        Of the electronics.
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
    @property
    def tilt_rate_rad_s(self) -> float: ...

class Detection:
    """
    How a beam's range was found.

    Members:

      NONE

      AMPLITUDE

      PHASE

      FALSE : Noise was taken for an echo.
    """

    AMPLITUDE: typing.ClassVar[Detection]
    FALSE: typing.ClassVar[Detection]
    NONE: typing.ClassVar[Detection]
    PHASE: typing.ClassVar[Detection]
    __members__: typing.ClassVar[dict[str, Detection]]
    @typing.overload
    def __eq__(self, other: Detection) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: Detection) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class PhysicsPing:
    """
    One multibeam ping in physics mode: Ping's arrays and more, read-only, a value a beam.
    """
    @property
    def angles_rad(self) -> numpy.ndarray:
        """
        (beams,) float32, about +z of the sonar, positive to port
        """
    @property
    def detections(self) -> numpy.ndarray:
        """
        (beams,) uint8, values of Detection
        """
    @property
    def incidence_rad(self) -> numpy.ndarray:
        """
        (beams,) float32 in [0, pi/2], true; NaN = no detection, or a false one
        """
    @property
    def intensity_db(self) -> numpy.ndarray:
        """
        (beams,) float32, received level less source level, with speckle and noise; -inf = no detection
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (beams,) uint16, true, see World.label_names; 0 where false
        """
    @property
    def model(self) -> int:
        """
        EM 2040 variant 1..4; 0: not of the wire
        """
    @property
    def points_sonar_m(self) -> numpy.ndarray:
        """
        (beams, 3) float32, the range along the beam's axis; NaN = no detection
        """
    @property
    def ranges_m(self) -> numpy.ndarray:
        """
        (beams,) float32, sound speed at the head x half the travel time; inf = no detection
        """
    @property
    def snr_db(self) -> numpy.ndarray:
        """
        (beams,) float32, over the noise, at the detector; -inf = none
        """
    @property
    def time_ns(self) -> int: ...
    @property
    def travel_time_s(self) -> numpy.ndarray:
        """
        (beams,) float32, two-way; inf = no detection
        """
    @property
    def valid(self) -> numpy.ndarray:
        """
        (beams,) bool: detected, be it falsely
        """
    @property
    def world_from_sonar(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]:
        """
        (4, 4) float64, at transmission
        """

class AcousticSpec:
    """
    What makes a multibeam an acoustic instrument.
    """

    false_detections: bool
    figures: SonarFigures
    range_noise: bool
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError that names the field.
        """
    @property
    def acidity_ph(self) -> float: ...
    @acidity_ph.setter
    def acidity_ph(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bending(self) -> bool:
        """
        Whether the sound speed's profile bends the beams.
        """
    @bending.setter
    def bending(self, arg0: bool) -> None: ...
    @property
    def bottom(self) -> BottomMaterial:
        """
        Of what has no line in `materials`.
        """
    @bottom.setter
    def bottom(self, arg0: BottomMaterial) -> None: ...
    @property
    def materials(self) -> list[BottomMaterial]:
        """
        By label, see World.label_names.
        """
    @materials.setter
    def materials(self, arg0: collections.abc.Sequence[BottomMaterial]) -> None: ...
    @property
    def rays_per_beam(self) -> int:
        """
        1, or 4 to 64
        """
    @rays_per_beam.setter
    def rays_per_beam(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...

class AcousticMultibeam:
    """
    A multibeam in physics mode by itself, without a vehicle. Pings do not depend on threads.
    """
    def __init__(
        self,
        model: MultibeamModel,
        spec: AcousticSpec,
        water: Water,
        seed: typing.SupportsInt | typing.SupportsIndex = 0,
        name: str = "sonar",
    ) -> None:
        """
        Raises ValueError that names the field.
        """
    def ping(
        self,
        scene: RayScene,
        position_world_m: typing.Any,
        orientation_xyzw: typing.Any,
        velocity_world_m_s: typing.Any = (0.0, 0.0, 0.0),
        rate_world_rad_s: typing.Any = (0.0, 0.0, 0.0),
        tick: typing.SupportsInt | typing.SupportsIndex = 0,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
    ) -> PhysicsPing:
        """
        One ping of the head at a pose (3,), (4,), moving (3,), (3,) in world axes. Random draws are keyed by tick.
        Raises ValueError. Releases the GIL.
        """
    @property
    def profile(self) -> SoundSpeedProfile:
        """
        Speed of sound of its water.
        """

class ImagingAcoustics:
    """
    What picture-making sonars share; see uwsim.imaging.Acoustics.
    """

    time_varied_gain: bool
    def __init__(self) -> None: ...
    def absorption_db_m(self, water: Water, head_z_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Of the water at the head [dB/m].
        """
    @property
    def bottom_strength_db(self) -> float: ...
    @bottom_strength_db.setter
    def bottom_strength_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def frequency_hz(self) -> float: ...
    @frequency_hz.setter
    def frequency_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def gain_db_decade(self) -> float: ...
    @gain_db_decade.setter
    def gain_db_decade(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def looks(self) -> int: ...
    @looks.setter
    def looks(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def noise_level_db(self) -> float: ...
    @noise_level_db.setter
    def noise_level_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def range_bins(self) -> int: ...
    @range_bins.setter
    def range_bins(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def range_max_m(self) -> float: ...
    @range_max_m.setter
    def range_max_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def solid_strength_db(self) -> float: ...
    @solid_strength_db.setter
    def solid_strength_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def source_level_db(self) -> float: ...
    @source_level_db.setter
    def source_level_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def strengths_db(self) -> list[float]:
        """
        By label; NaN: bottom's or solids'.
        """
    @strengths_db.setter
    def strengths_db(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...

class ForwardLookingModel:
    """
    See uwsim.imaging.ForwardLooking.
    """

    acoustics: ImagingAcoustics
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError.
        """
    @property
    def beam_width_rad(self) -> float: ...
    @beam_width_rad.setter
    def beam_width_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def beams(self) -> int: ...
    @beams.setter
    def beams(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def columns_per_beam(self) -> int: ...
    @columns_per_beam.setter
    def columns_per_beam(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def field_of_view_rad(self) -> float: ...
    @field_of_view_rad.setter
    def field_of_view_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def rays_per_column(self) -> int: ...
    @rays_per_column.setter
    def rays_per_column(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def taper(self) -> float: ...
    @taper.setter
    def taper(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def vertical_width_rad(self) -> float: ...
    @vertical_width_rad.setter
    def vertical_width_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class SideScanModel:
    """
    See uwsim.imaging.SideScan.
    """

    acoustics: ImagingAcoustics
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError.
        """
    @property
    def along_width_rad(self) -> float: ...
    @along_width_rad.setter
    def along_width_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def depression_rad(self) -> float: ...
    @depression_rad.setter
    def depression_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def detection_db(self) -> float: ...
    @detection_db.setter
    def detection_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def planes(self) -> int: ...
    @planes.setter
    def planes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def vertical_width_rad(self) -> float: ...
    @vertical_width_rad.setter
    def vertical_width_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class SingleBeamModel:
    """
    See uwsim.imaging.SingleBeam.
    """

    acoustics: ImagingAcoustics
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError.
        """
    @property
    def beam_width_rad(self) -> float: ...
    @beam_width_rad.setter
    def beam_width_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def detection_db(self) -> float: ...
    @detection_db.setter
    def detection_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def rays_across(self) -> int: ...
    @rays_across.setter
    def rays_across(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...

class DepthCamera:
    """
    See uwsim.depth_map.DepthMap.
    """
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raises ValueError.
        """
    @property
    def depth_bits(self) -> int: ...
    @depth_bits.setter
    def depth_bits(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def height(self) -> int: ...
    @height.setter
    def height(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def horizontal_fov_rad(self) -> float: ...
    @horizontal_fov_rad.setter
    def horizontal_fov_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def range_max_m(self) -> float: ...
    @range_max_m.setter
    def range_max_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def vertical_fov_rad(self) -> float: ...
    @vertical_fov_rad.setter
    def vertical_fov_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def width(self) -> int: ...
    @width.setter
    def width(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...

class RowReduction:
    """
    Members:

      MIDDLE

      NEAREST
    """

    MIDDLE: typing.ClassVar[RowReduction]
    NEAREST: typing.ClassVar[RowReduction]
    __members__: typing.ClassVar[dict[str, RowReduction]]
    @typing.overload
    def __eq__(self, other: RowReduction) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: RowReduction) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class MapEngine:
    """
    Members:

      OCTOMAP

      BRICKS
    """

    BRICKS: typing.ClassVar[MapEngine]
    OCTOMAP: typing.ClassVar[MapEngine]
    __members__: typing.ClassVar[dict[str, MapEngine]]
    @typing.overload
    def __eq__(self, other: MapEngine) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: MapEngine) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class InstructionSet:
    """
    Forms of the brick engine's inner loops, all with the same result.

    Members:

      BEST

      PORTABLE

      AVX2

      AVX512
    """

    AVX2: typing.ClassVar[InstructionSet]
    AVX512: typing.ClassVar[InstructionSet]
    BEST: typing.ClassVar[InstructionSet]
    PORTABLE: typing.ClassVar[InstructionSet]
    __members__: typing.ClassVar[dict[str, InstructionSet]]
    @typing.overload
    def __eq__(self, other: InstructionSet) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: InstructionSet) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class MapOptions:
    """
    What a map is made of, and its probabilities of hit, miss and clamping.
    """
    def __init__(
        self,
        *,
        engine: MapEngine,
        hit: typing.SupportsFloat | typing.SupportsIndex,
        miss: typing.SupportsFloat | typing.SupportsIndex,
        clamping_min: typing.SupportsFloat | typing.SupportsIndex,
        clamping_max: typing.SupportsFloat | typing.SupportsIndex,
        instruction_set: InstructionSet,
        count_outside: bool,
        memory_limit_mb: typing.SupportsFloat | typing.SupportsIndex | None,
        spill_folder: str,
    ) -> None: ...

class OccupancyMap:
    """
    OctoMap's octree, about an origin in the world.
    """
    @staticmethod
    def read(path: os.PathLike[str] | str | bytes, origin_world_m: typing.Any, options: MapOptions) -> OccupancyMap:
        """
        A map from a .bt or .ot file. Raises OSError if it cannot be read, ValueError if it is no sound map of
        OctoMap's. Releases the GIL.
        """
    def __init__(
        self, resolution_m: typing.SupportsFloat | typing.SupportsIndex, origin_world_m: typing.Any, options: MapOptions
    ) -> None: ...
    def cast_rays(
        self,
        origins_world_m: typing.Any,
        directions_world: typing.Any,
        ignore_unknown: bool,
        max_range_m: typing.SupportsFloat | typing.SupportsIndex,
    ) -> tuple[numpy.typing.NDArray[numpy.int8], numpy.typing.NDArray[numpy.float64]]:
        """
        (n, 3) float64 each. Returns (n,) int8 ends: 1 occupied, 0 range or edge, -1 unknown, and (n, 3) float64
        centres of the last voxels. Releases the GIL.
        """
    def cells(
        self, depth: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]
    ]:
        """
        As leaves, of the cubes at a depth of the tree, 1 to 16. Releases the GIL.
        """
    def changed_voxels(self) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int8]]:
        """
        (n, 3) float64 centres and (n,) int8 states of what changed since the last call. Releases the GIL.
        """
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
    def insert_scans(
        self,
        points_world_m: typing.Any,
        counts: typing.Any,
        origins_world_m: typing.Any,
        max_range_m: typing.SupportsFloat | typing.SupportsIndex,
        threads: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        points_world_m: (n, 3) float32 of all scans; counts: (m,) int64; origins_world_m: (m, 3) float64. Raises
        ValueError as insert_scan does, inserting none of them. Releases the GIL.
        """
    def leaves(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]
    ]:
        """
        Centres (n, 3) float64, edges (n,) float64, log-odds (n,) float32 of the pruned tree's leaves. Releases the GIL.
        """
    def log_odds_at(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.float32]:
        """
        points_world_m: (n, 3) float64, finite. Returns (n,) float32, NaN where unknown. Releases the GIL.
        """
    def merge(self, other: OccupancyMap) -> None:
        """
        Adds the other's log-odds. Raises ValueError. Releases the GIL.
        """
    def model(self) -> tuple[float, float, float, float]: ...
    def occupied_voxels(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 3) float64: centres of the finest voxels, world, in Morton order. Releases the GIL.
        """
    def set_model(
        self,
        hit: typing.SupportsFloat | typing.SupportsIndex,
        miss: typing.SupportsFloat | typing.SupportsIndex,
        clamping_min: typing.SupportsFloat | typing.SupportsIndex,
        clamping_max: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Of later scans. Raises ValueError. Releases the GIL.
        """
    def state_at(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.int8]:
        """
        points_world_m: (n, 3) float64, finite. Returns (n,) int8: 1 occupied, 0 free, -1 unknown. Releases the GIL.
        """
    def statistics(self) -> tuple[int, int, int, int, int, int]:
        """
        (occupied voxels, free voxels, nodes, bytes of memory, points left out, evictions). Releases the GIL.
        """
    def to_bytes(self, format: str) -> bytes:
        """
        The bytes of a 'bt' or 'ot' file. Releases the GIL.
        """
    def voxels_in(
        self, low_world_m: typing.Any, high_world_m: typing.Any
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]
    ]:
        """
        As leaves, of the finest voxels with centres in a box, (3,) float64 each. Releases the GIL.
        """
    def write(self, path: os.PathLike[str] | str | bytes, format: str) -> None:
        """
        Atomically. Raises OSError. Releases the GIL.
        """
    @property
    def engine(self) -> MapEngine: ...
    @property
    def origin_world_m(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def resolution_m(self) -> float: ...

class WaterOptics:
    """
    A water's coefficients [1/m], (3,) in the order red, green, blue.
    """
    @staticmethod
    def jerlov(type: str) -> WaterOptics:
        """
        Of a Jerlov type (sources in water_optics.h). Raises ValueError for an unknown one.
        """
    def __init__(
        self,
        diffuse_attenuation: typing.Any,
        absorption: typing.Any,
        scattering: typing.Any,
        refractive_index: typing.SupportsFloat | typing.SupportsIndex = 1.333,
    ) -> None: ...
    @property
    def absorption(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def beam_attenuation(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def diffuse_attenuation(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def refractive_index(self) -> float: ...
    @property
    def scattering(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...

class Optics:
    """
    What light is like: the water, the sun, the wind on the surface, what drifts.
    """
    def __init__(
        self,
        water: WaterOptics,
        sun_elevation_rad: typing.SupportsFloat | typing.SupportsIndex,
        sun_azimuth_rad: typing.SupportsFloat | typing.SupportsIndex,
        wind_m_s: typing.SupportsFloat | typing.SupportsIndex,
        wind_towards_rad: typing.SupportsFloat | typing.SupportsIndex,
        particles_per_m3: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    def level_irradiance_below(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) of the daylight just below a flat surface; 1 is the sun's outside the air.
        """
    @property
    def to_sun_below_world(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def to_sun_world(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def water(self) -> WaterOptics: ...

class Lens:
    """
    As OpenCV's and CameraInfo's plumb_bob; pixels; see lens.h for the equations.
    """
    def __init__(
        self,
        width: typing.SupportsInt | typing.SupportsIndex,
        height: typing.SupportsInt | typing.SupportsIndex,
        fx: typing.SupportsFloat | typing.SupportsIndex,
        fy: typing.SupportsFloat | typing.SupportsIndex,
        cx: typing.SupportsFloat | typing.SupportsIndex,
        cy: typing.SupportsFloat | typing.SupportsIndex,
        distortion: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(5)"
        ] = [0.0, 0.0, 0.0, 0.0, 0.0],
    ) -> None:
        """
        distortion: k1, k2, p1, p2, k3.
        """

class Camera:
    """
    Lens and sensor. Raises ValueError that names the figure.
    """
    def __init__(
        self,
        name: str,
        lens: Lens,
        exposure: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        full_well: typing.SupportsFloat | typing.SupportsIndex = 8000.0,
        read_noise: typing.SupportsFloat | typing.SupportsIndex = 6.0,
        vignetting: typing.SupportsFloat | typing.SupportsIndex = 0.5,
        wobble_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0008,
    ) -> None: ...
    @property
    def name(self) -> str: ...

class LampLight:
    """
    A spot lamp that shines along its x; irradiance 1 is taken as 1e5 lx.
    """
    def __init__(
        self,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        flux_lm: typing.SupportsFloat | typing.SupportsIndex,
        half_angle_rad: typing.SupportsFloat | typing.SupportsIndex,
        soft_share: typing.SupportsFloat | typing.SupportsIndex,
        colour: typing.Any,
    ) -> None: ...

class Picture:
    """
    Read-only arrays of one pass, rows from the top; see picture.h.
    """
    @property
    def classes(self) -> numpy.ndarray:
        """
        (H, W) uint8, see surface_class_names()
        """
    @property
    def depth_m(self) -> numpy.ndarray:
        """
        (H, W) float32 along the optical axis, inf = nothing
        """
    @property
    def gain(self) -> float:
        """
        exposure that made rgb of radiance
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (H, W) uint16, see CameraScene.label_names
        """
    @property
    def normals_world(self) -> numpy.ndarray:
        """
        (H, W, 3) float32, 0 = nothing
        """
    @property
    def packets(self) -> bytes:
        """
        What was cast, as tools/bench/native/embree_bare_rays reads it
        """
    @property
    def radiance(self) -> numpy.ndarray:
        """
        (H, W, 3) float32 before exposure, where asked for
        """
    @property
    def rays(self) -> dict[str, int]:
        """
        How many were cast, by kind.
        """
    @property
    def rgb(self) -> numpy.ndarray:
        """
        (H, W, 3) uint8, sRGB; (0, W, 3) where geometry alone was asked for
        """
    @property
    def stage_s(self) -> dict[str, float]:
        """
        Seconds of all threads together by stage, where measured.
        """

class CameraScene:
    """
    The world that feeds physics and rays, with looks; and the vehicles. A snapshot of the world.
    """
    def __init__(self, world: World, rays: RayScene, seed: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def add_body(
        self, name: str, vertices_body_m: typing.Any, triangles: typing.Any, material: str, colour: typing.Any = None
    ) -> int:
        """
        Returns the body's index.
        """
    def render(
        self,
        camera: Camera,
        optics: Optics,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        time_s: typing.SupportsFloat | typing.SupportsIndex,
        tick: typing.SupportsInt | typing.SupportsIndex,
        effects: collections.abc.Sequence[str],
        lamps: collections.abc.Sequence[LampLight] = [],
        body_positions_m: typing.Any = None,
        body_orientations_xyzw: typing.Any = None,
        hidden_body: typing.SupportsInt | typing.SupportsIndex | None = None,
        geometry_only: bool = False,
        keep_radiance: bool = False,
        measure: bool = False,
        record: bool = False,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
    ) -> Picture:
        """
        One picture; the camera's frame is x ahead, y left, z up. effects: names of those that are on. body_positions_m: (n, 3), body_orientations_xyzw: (n, 4), of all bodies or none. Same bytes whatever the number of threads. Releases the GIL. Raises ValueError.
        """
    def set_ground(self, bed: str, steep: str, land: str) -> None: ...
    def set_look(
        self,
        label: typing.SupportsInt | typing.SupportsIndex,
        material: str,
        surface_class: str,
        colour: typing.Any = None,
        texture_image: typing.Any = None,
        texture_corners: typing.Any = None,
    ) -> None:
        """
        colour: (3,) albedo. texture_image: (H, W, 3) uint8 sRGB; texture_corners: (triangles, 3, 2), from the lower left. Raises ValueError.
        """
    @property
    def label_names(self) -> list[str]:
        """
        World.label_names, then the bodies'.
        """

class SensorParameter:
    """
    A figure that a kind of sensor takes.
    """
    @property
    def by_default(self) -> float:
        """
        of each value; NaN: must be given
        """
    @property
    def high(self) -> float: ...
    @property
    def low(self) -> float: ...
    @property
    def meaning(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def width(self) -> int:
        """
        how many values it has
        """

class SensorKind:
    """
    A kind of sensor.
    """
    @property
    def channels(self) -> dict[str, tuple[int, str]]:
        """
        {name: (width, unit)} of what noise acts on
        """
    @property
    def fields(self) -> dict[str, tuple[int, str]]:
        """
        {name: (width, unit)} of a reading
        """
    @property
    def meaning(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict[str, SensorParameter]:
        """
        {name: SensorParameter}
        """

class NoiseSpec:
    """
    Errors of one channel of a sensor, in its unit u: std, density (white: a sample's, and per root hertz), turn_on_std, bias_std with bias_time_s (Gauss-Markov), walk (u per root second), quantum, limits. 0: none.
    """
    def __init__(
        self,
        *,
        std: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        density: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        turn_on_std: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        bias_std: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        bias_time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        walk: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        quantum: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        limit_low: typing.SupportsFloat | typing.SupportsIndex = ...,
        limit_high: typing.SupportsFloat | typing.SupportsIndex = ...,
    ) -> None: ...

class SensorSpec:
    def __init__(
        self,
        name: str,
        kind: str,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        *,
        parameters: collections.abc.Mapping[
            str, collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]
        ] = {},
        noise: collections.abc.Mapping[str, NoiseSpec] = {},
        rate_hz: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        latency_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        drop_out: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        parameters: of the kind; noise: by channel; rate_hz: 0 for every step. Checked when a vehicle takes it.
        """
    @property
    def drop_out(self) -> float: ...
    @property
    def kind(self) -> str: ...
    @property
    def latency_s(self) -> float: ...
    @property
    def name(self) -> str: ...
    @property
    def rate_hz(self) -> float: ...

class SensorReading:
    """
    One sample of a sensor.
    """
    @property
    def stamp_ns(self) -> int:
        """
        when it was taken
        """
    @property
    def valid(self) -> bool: ...
    @property
    def values(self) -> dict[str, typing.Any]:
        """
        {field: float or (n,) float64}
        """

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

class SonarSpec:
    def __init__(
        self,
        name: str,
        model: MultibeamModel,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        elevation_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        acoustics: AcousticSpec | None = None,
    ) -> None:
        """
        acoustics: in physics mode; without, in geometry mode.
        """
    @property
    def model(self) -> MultibeamModel: ...
    @property
    def name(self) -> str: ...

class CollisionShape:
    """
    Members:

      HULL

      BOX

      PIECES
    """

    BOX: typing.ClassVar[CollisionShape]
    HULL: typing.ClassVar[CollisionShape]
    PIECES: typing.ClassVar[CollisionShape]
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
    actuators: ActuatorsSpec
    craft: Craft
    docked: bool
    name: str
    shape: CollisionShape
    def __init__(self) -> None: ...
    def set_collision_pieces(self, pieces_body_m: collections.abc.Sequence[numpy.ndarray]) -> None:
        """
        Each (n, 3): the corners of a convex piece, body frame; the shape becomes PIECES.
        """
    def set_start(self, position_m: typing.Any, orientation_xyzw: typing.Any) -> None: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
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
    def acoustic_ping(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
    ) -> PhysicsPing:
        """
        Of a sonar in physics mode. Raises ValueError in geometry mode. Releases the GIL.
        """
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
        Positive is up; the head turns there as time passes. Raises ValueError.
        """
    def collisions(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> int:
        """
        How often it came to touch something.
        """
    def controllable(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[list[bool], "FixedSize(6)"]:
        """
        Whether an effort does something, surge to yaw.
        """
    def effort(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]: ...
    def fin_angles_rad(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        (name, deflection now [rad]) pairs of those that move.
        """
    def full_wrench_body(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[list[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]], "FixedSize(2)"]:
        """
        Two (6,): the largest wrench about each axis alone, ahead and astern, magnitudes [N, N m].
        """
    def in_physics_mode(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> bool: ...
    def ping(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> Ping: ...
    def ping_batch(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        world_from_body: typing.Any,
        threads: typing.SupportsInt | typing.SupportsIndex | None = None,
    ) -> PingBatch:
        """
        world_from_body: (n, 4, 4) float64, rigid. Geometry mode, the head as it is tilted now. The same results
        whatever the threads (by default all). Raises ValueError. Releases the GIL, answers Ctrl-C.
        """
    def read_sensor(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sensor: typing.SupportsInt | typing.SupportsIndex,
        with_noise: bool = True,
    ) -> SensorReading:
        """
        Repeated at one time it is the same sample. Without noise: the present, without rate, delay and drop-outs.
        """
    def release(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def released(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> bool: ...
    def restore_state(self, state: bytes, scenario: str, build: str) -> str:
        """
        Returns the notes. Raises ValueError, changing nothing, for a state that is damaged or has other fingerprints.
        """
    def save_state(self, scenario: str, build: str, notes: str = "") -> bytes:
        """
        All that the future depends on beside what the simulation was made of, with fingerprints of that.
        notes: kept with it.
        """
    def set_effort(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        effort: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
    ) -> None:
        """
        (6,) surge sway heave roll pitch yaw in [-1, 1]. Raises ValueError.
        """
    def set_fins(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        angles_rad: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
    ) -> None:
        """
        (name, deflection) pairs; unnamed ones centre. Raises ValueError.
        """
    def set_state(self, vehicle: typing.SupportsInt | typing.SupportsIndex, state: BodyState) -> None: ...
    def set_thrusters(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        commands: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
    ) -> None:
        """
        (name, command in [-1, 1]) pairs; unnamed ones stop. Raises ValueError.
        """
    def set_wrench(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        wrench_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
    ) -> None:
        """
        (6,) [N, N m]; beyond the thrusters it keeps its direction.
        """
    def sonar_elevation_rad(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> float:
        """
        Where the head points now.
        """
    def sonar_ping_rate_max_hz(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> float:
        """
        By two-way travel time, c / (2 range), c at the head.
        """
    def state(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> BodyState: ...
    def step(self, count: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        """
        Fixed steps; releases the GIL, answers Ctrl-C.
        """
    def telemetry(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> Telemetry: ...
    def thruster_commands(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        (name, command) pairs.
        """
    def thrusts_n(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        (name, still-water thrust now [N]) pairs.
        """
    @property
    def tick(self) -> int: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def version(self) -> int:
        """
        Changes whenever something may look different: time, a place, an aim.
        """

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

class PingBatch:
    """
    Several pings of one sonar. Arrays are read-only, a row a ping; see Ping.
    """
    @property
    def angles_rad(self) -> numpy.ndarray:
        """
        (beams,) float32, the same for all
        """
    @property
    def incidence_rad(self) -> numpy.ndarray:
        """
        (n, beams) float32 in [0, pi/2], NaN = no echo
        """
    @property
    def intensity_db(self) -> numpy.ndarray:
        """
        (n, beams) float32, -inf = no echo
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (n, beams) uint16
        """
    @property
    def model(self) -> int:
        """
        EM 2040 variant 1..4
        """
    @property
    def points_sonar_m(self) -> numpy.ndarray:
        """
        (n, beams, 3) float32, NaN = no echo
        """
    @property
    def ranges_m(self) -> numpy.ndarray:
        """
        (n, beams) float32, inf = no echo
        """
    @property
    def valid(self) -> numpy.ndarray:
        """
        (n, beams) bool
        """
    @property
    def world_from_sonar(self) -> numpy.ndarray:
        """
        (n, 4, 4) float64
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

def depth_image(
    camera: DepthCamera,
    scene: RayScene,
    position_m: typing.Any,
    orientation_xyzw: typing.Any,
    threads: typing.SupportsInt | typing.SupportsIndex = 1,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    (height, width) float32 along the camera's x axis, inf = nothing. Raises ValueError. Releases the GIL.
    """

def depth_image_ranges(
    camera: DepthCamera, depth_m: typing.Any, angles_rad: typing.Any, reduction: RowReduction, interpolate: bool
) -> numpy.typing.NDArray[numpy.float32]:
    """
    depth_m (height, width), angles_rad (n,) -> (n,) float32, inf = no echo. Raises ValueError.
    """

def detection_probability(
    snr: typing.SupportsFloat | typing.SupportsIndex,
    looks: typing.SupportsFloat | typing.SupportsIndex,
    detection_threshold_db: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    snr: a ratio, not dB. looks: independent ones that the echo holds.
    """

def effect_names() -> list[str]: ...
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

def forward_look(
    model: ForwardLookingModel,
    scene: RayScene,
    water: Water,
    position_m: typing.Any,
    orientation_xyzw: typing.Any,
    seed: typing.SupportsInt | typing.SupportsIndex,
    stream: str,
    tick: typing.SupportsInt | typing.SupportsIndex,
    threads: typing.SupportsInt | typing.SupportsIndex = 1,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    (bins, beams) float32, dB re 1 uPa; pose: world from sonar. Raises ValueError. Releases the GIL.
    """

def ground_plane(
    points_m: typing.Any,
    distance_m: typing.SupportsFloat | typing.SupportsIndex,
    max_slope_rad: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"], float, numpy.ndarray]:
    """
    pcl::RandomSampleConsensus: normal (3,) that looks up, offset [m] with normal . p + offset = 0, and the inliers
    (n,) bool. points_m: (n, 3) float32, finite. Raises ValueError. Releases the GIL.
    """

def jerlov_types() -> list[str]:
    """
    Names of the Jerlov water types.
    """

def material_names() -> list[str]: ...
def mounted(
    position_m: typing.Any,
    orientation_xyzw: typing.Any,
    mount_position_m: typing.Any,
    mount_orientation_xyzw: typing.Any,
) -> tuple[
    typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"],
    typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"],
    typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"],
]:
    """
    Pose of what is mounted on a carrier: position (3,), orientation (4,) as x, y, z, w, and both as (4, 4).
    """

def multibeam_model(number: typing.SupportsInt | typing.SupportsIndex) -> MultibeamModel:
    """
    The EM 2040 MKII variant 1..4. Raises ValueError for other numbers.
    """

def nadir_area_m2(
    sonar: SonarFigures,
    bottom: BottomMaterial,
    range_m: typing.SupportsFloat | typing.SupportsIndex,
    sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    Bottom straight below that scatters one range cell's worth [m2].
    """

def nadir_snr_db(
    sonar: SonarFigures,
    bottom: BottomMaterial,
    range_m: typing.SupportsFloat | typing.SupportsIndex,
    sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
    absorption_db_m: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    The active sonar equation straight below [dB].
    """

def pass_through(
    points_m: typing.Any,
    axis: typing.SupportsInt | typing.SupportsIndex,
    min_m: typing.SupportsFloat | typing.SupportsIndex,
    max_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::PassThrough: the points whose coordinate 0, 1 or 2 is in [min_m, max_m]; (n, 3) float32. Points that are
    not finite drop out. Raises ValueError. Releases the GIL.
    """

def refracted(
    direction: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
    normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
    n_from: typing.SupportsFloat | typing.SupportsIndex,
    n_to: typing.SupportsFloat | typing.SupportsIndex,
) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"] | None:
    """
    Snell's law; normal points to where the ray comes from. None where it is totally reflected.
    """

def register_cloud(
    source_m: typing.Any,
    target_m: typing.Any,
    guess: typing.Any,
    max_distance_m: typing.SupportsFloat | typing.SupportsIndex,
    max_iterations: typing.SupportsInt | typing.SupportsIndex,
) -> tuple[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"], float, float, int, bool]:
    """
    pcl::IterativeClosestPoint: target_from_source (4, 4), rms [m] and share of the points within reach, iterations,
    converged. source_m, target_m: (n, 3) float32, finite. guess: (4, 4), rigid. Raises ValueError. Releases the GIL.
    """

def remove_box(
    points_m: typing.Any, box_min_m: typing.Any, box_max_m: typing.Any
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::CropBox, negative: the points outside the box, whose faces belong to it; (n, 3) float32. box_*_m: (3,)
    float64. Points that are not finite drop out. Raises ValueError. Releases the GIL.
    """

def remove_outliers(
    points_m: typing.Any,
    neighbours: typing.SupportsInt | typing.SupportsIndex,
    deviations: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::StatisticalOutlierRemoval; (n, 3) float32. Points that are not finite drop out. Raises ValueError. Releases
    the GIL.
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

def sea_water_density_kg_m3(
    temperature_deg_c: typing.SupportsFloat | typing.SupportsIndex,
    salinity_psu: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    At atmospheric pressure, by EOS-80 (UNESCO 44, 1983).
    """

def sensor_kind(name: str) -> SensorKind:
    """
    Raises ValueError with the names there are.
    """

def sensor_kinds() -> list[str]:
    """
    The kinds of sensor that are built in.
    """

def side_scan(
    model: SideScanModel,
    scene: RayScene,
    water: Water,
    positions_m: typing.Any,
    orientations_xyzw: typing.Any,
    seed: typing.SupportsInt | typing.SupportsIndex,
    stream: str,
    first_ping: typing.SupportsInt | typing.SupportsIndex,
    threads: typing.SupportsInt | typing.SupportsIndex = 1,
) -> tuple[
    numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]
]:
    """
    Poses (n, 3) and (n, 4). (port_db (n, bins), starboard_db (n, bins), altitude_m (n,)), float32. Raises ValueError. Releases the GIL.
    """

def single_beam(
    model: SingleBeamModel,
    scene: RayScene,
    water: Water,
    position_m: typing.Any,
    orientation_xyzw: typing.Any,
    angles_rad: typing.Any,
    seed: typing.SupportsInt | typing.SupportsIndex,
    stream: str,
    first_ping: typing.SupportsInt | typing.SupportsIndex,
    threads: typing.SupportsInt | typing.SupportsIndex = 1,
) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
    """
    angles_rad (n,). (level_db (n, bins), ranges_m (n,)), float32, inf = no echo. Raises ValueError. Releases the GIL.
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

def sound_speed_profile(water: Water) -> SoundSpeedProfile:
    """
    The water's speed of sound by depth: as its profile gives it, else Mackenzie's.
    """

def soundings(
    directions_world: typing.Any, travel_time_s: typing.Any, origin_world_m: typing.Any, profile: SoundSpeedProfile
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Points (n, 3) float64, world, that a survey computes: sound traced along directions_world (n, 3), as sent, for
    half of the two-way travel_time_s (n,), through `profile`, which need not be the true one. NaN where the time
    is not finite. Raises ValueError. Releases the GIL.
    """

def surface_class_names() -> list[str]: ...
def transform_points(
    points_source_m: typing.Any, target_from_source: typing.Any
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::transformPointCloud: (n, 3) float32 in, (n, 3) float32 out. target_from_source: (4, 4) float64, rigid.
    Raises ValueError. Releases the GIL.
    """

def voxel_grid(
    points_m: typing.Any, voxel_m: typing.SupportsFloat | typing.SupportsIndex
) -> numpy.typing.NDArray[numpy.float32]:
    """
    pcl::VoxelGrid: the centroid of the points in each cube of edge voxel_m; (n, 3) float32 in, (k, 3) float32 out.
    Points that are not finite drop out. Raises ValueError. Releases the GIL.
    """
