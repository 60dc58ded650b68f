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
    "AppliedWrench",
    "ArmLink",
    "ArmReading",
    "Arrival",
    "Autopilot",
    "AutopilotGains",
    "Batch",
    "BatterySpec",
    "BatteryState",
    "BiasModel",
    "BodyPath",
    "BodyState",
    "BottomMaterial",
    "Camera",
    "CameraScene",
    "CollisionShape",
    "ContactForce",
    "ControlGains",
    "ControlModel",
    "Craft",
    "CraftParameters",
    "Current",
    "DepthCamera",
    "Detection",
    "DistanceField",
    "DynamicsEngine",
    "FinParameters",
    "FixedWater",
    "FixedWorld",
    "FlatPort",
    "Guidance",
    "ImagingKind",
    "ImagingSonar",
    "InstructionSet",
    "JointKind",
    "Lens",
    "LinkDelivery",
    "LinkFault",
    "LinkKind",
    "LinkQuality",
    "LinkSpec",
    "LinkWater",
    "LoopGains",
    "MapEngine",
    "MapOptions",
    "Mechanism",
    "MediumAccess",
    "MemberSpec",
    "ModemSpec",
    "Modulation",
    "MotionController",
    "MultibeamModel",
    "NavigationFilter",
    "NoiseSpec",
    "ObjectSpec",
    "OccupancyMap",
    "Optics",
    "Parameter",
    "PathFollower",
    "PhysicsPing",
    "Picture",
    "Pid",
    "PidGains",
    "Ping",
    "PingBatch",
    "RANGING_PING_BYTES",
    "RayHits",
    "RayScene",
    "Reception",
    "RoundShape",
    "RowReduction",
    "SensorKind",
    "SensorReading",
    "SensorSpec",
    "ServoCounts",
    "ServoExchange",
    "ServoMotor",
    "Simulation",
    "SimulationSpec",
    "SolidProperties",
    "SonarParameters",
    "SonarSpec",
    "SoundSpeedProfile",
    "SpotLamp",
    "SurfaceSampler",
    "SurfaceVoxels",
    "Tape",
    "Telemetry",
    "TetherEnd",
    "TetherReading",
    "TetherSpec",
    "ThrustCurve",
    "ThrusterParameters",
    "ThrusterSheet",
    "ThrusterSheets",
    "TopicCounts",
    "VehicleSpec",
    "VoxelScene",
    "Water",
    "WaterOptics",
    "WaterProfile",
    "WaterTargets",
    "Waves",
    "Windage",
    "World",
    "absorption_db_km",
    "added_mass",
    "ambient_noise_db_hz",
    "arrivals",
    "bit_error",
    "bottom_echo",
    "bottom_loss_db",
    "decode_depth_string",
    "depth_image",
    "depth_image_ranges",
    "effect_names",
    "encode_depth_string",
    "filter_range",
    "ground_plane",
    "highest_in_corridor",
    "imaging_kind",
    "imaging_kinds",
    "instruction_set",
    "jerlov_types",
    "material_names",
    "mounted_pose",
    "mounted_poses",
    "multibeam_model",
    "packet_error",
    "pass_through",
    "play_servo_frames",
    "points_above",
    "refracted",
    "relative_transform",
    "remove_box",
    "remove_outliers",
    "remove_unfinished_files",
    "render_many",
    "run_servo_exchanges",
    "saved_build",
    "saved_notes",
    "scan_to_points",
    "scan_to_world",
    "sea_water_density_kg_m3",
    "seabed_backscatter_db",
    "seabeds",
    "sensor_kind",
    "sensor_kinds",
    "solid_properties",
    "sound_speed_m_s",
    "sound_speed_profile",
    "soundings",
    "stream_name",
    "surface_class_names",
    "surface_loss_db",
    "transform_points",
    "voxel_grid",
    "water_targets_at",
]

class Parameter:
    """
    A parameter of a kind of sensor or imaging sonar.
    """
    @property
    def by_default(self) -> float:
        """
        default of each value; NaN if the parameter is required
        """
    @property
    def high(self) -> float: ...
    @property
    def low(self) -> float:
        """
        smallest value; the smallest positive number if 0 is excluded
        """
    @property
    def meaning(self) -> str: ...
    @property
    def type(self) -> str:
        """
        "number", "whole number" or "flag"
        """
    @property
    def unit(self) -> str: ...
    @property
    def width(self) -> int:
        """
        number of values
        """

class BodyState:
    """
    Pose and velocity of a body, in read-only arrays; six-vectors are (linear, angular) in the body frame.
    """
    def __init__(self, position_m: typing.Any, orientation_xyzw: typing.Any, velocity_body: typing.Any) -> None: ...
    @property
    def orientation_xyzw(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (4,)
        """
    @property
    def position_world_m(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) [m]
        """
    @property
    def velocity_body(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (6,) [m/s, rad/s]
        """
    @property
    def world_from_body(self) -> numpy.typing.NDArray[numpy.float64]:
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
        (3, 3) [m^5], about the centroid; multiplied by the density, in kg m^2
        """
    @property
    def volume_m3(self) -> float: ...

class Waves:
    """
    Linear (Airy) waves on water of constant depth, with Wheeler's stretching (1970) near the surface.
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
        Return a single wave that propagates towards heading_rad (from east, counter-clockwise). Raises
        ValueError.
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
        Return a sea of component_count waves with a JONSWAP spectrum, or the TMA spectrum in finite depth.
        Raises ValueError.
        """
    @property
    def bound_m(self) -> float:
        """
        the sum of the amplitudes: no crest is higher, no trough deeper
        """
    @property
    def components(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 4]"]:
        """
        (n, 4): amplitude [m], angular frequency [rad/s], heading and phase [rad] of each wave
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
    A current: a function of position and time. Its constructors raise ValueError.
    """
    @staticmethod
    def gridded(
        x_m: typing.Any, y_m: typing.Any, z_m: typing.Any, velocity_m_s: typing.Any, t_s: typing.Any = None
    ) -> Current:
        """
        Return a steady field, velocity_m_s (nz, ny, nx, 3) on increasing axes, or with t_s one that varies,
        velocity_m_s (nt, nz, ny, nx, 3): linear along each axis, constant beyond the edges.
        """
    @staticmethod
    def gusty(
        sigma_m_s: typing.Any,
        correlation_time_s: typing.SupportsFloat | typing.SupportsIndex,
        seed: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> Current:
        """
        Return Gauss-Markov gusts with standard deviation sigma_m_s (3,) and zero mean.
        """
    @staticmethod
    def harmonic(speed_rad_s: typing.Any, cosine_m_s: typing.Any, sine_m_s: typing.Any) -> Current:
        """
        Return the sum of cosine_m_s cos(speed t) + sine_m_s sin(speed t): speed_rad_s (n,), others (n, 2), east
        and north.
        """
    @staticmethod
    def layered(depth_m: typing.Any, velocity_m_s: typing.Any) -> Current:
        """
        Return a steady current, linear between levels. depth_m: (n,), increasing; velocity_m_s: (n, 3).
        """
    @staticmethod
    def tidal(
        amplitude_m_s: typing.Any,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
        phase_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> Current:
        """
        Return a tidal current: amplitude_m_s (3,) times sin(2 pi t / period_s + phase_rad).
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
        Create a profile from arrays (n,), with increasing depths. Without sound_speed_m_s, the sound speed is
        computed from the other properties. Raises ValueError.
        """

class Water:
    """
    The water of a world: calm and uniform with one steady current, unless waves, a profile or currents
    are set.
    """
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...
    def add_current(self, current: Current) -> None:
        """
        Add a current to current_world_m_s and to those added earlier.
        """
    def check(self) -> None:
        """
        Raise ValueError naming the field, its value, unit and rule if a parameter is invalid.
        """
    def density_at_kg_m3(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Return the density of still water.
        """
    def pressure_at_pa(
        self, points_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the absolute pressure (n,) at points (n, 3) under the waves at this time.
        """
    def pressure_pa(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Return the absolute pressure of still water: p_atm + the integral of rho g, with compression.
        """
    def salinity_at_points_psu(
        self, points_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the salinity (n,) at points (n, 3): that of the masses, if there are any.
        """
    def salinity_at_psu(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    def set_masses(
        self,
        x_m: typing.Any,
        y_m: typing.Any,
        z_m: typing.Any,
        t_s: typing.Any,
        temperature_deg_c: typing.Any,
        salinity_psu: typing.Any,
    ) -> None:
        """
        Set temperature and salinity (nt, nz, ny, nx) on axes that rise, as instruments measure them. Raises
        ValueError.
        """
    def set_tide(self, constituents: typing.Any) -> None:
        """
        Let the still surface move: rows (n, 3) of amplitude [m], speed [rad/s] and phase [rad], of the height
        amplitude cos(speed t - phase). Raises ValueError.
        """
    def sound_speed_m_s(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Return the speed of sound, from the profile if it specifies one, else by temperature, salinity and
        pressure (sound_speed_equation).
        """
    def surface_height_m(
        self, xy_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the surface height (n,) at positions (n, 2).
        """
    def temperature_at_deg_c(
        self, points_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the temperature (n,) at points (n, 3): that of the masses, if there are any.
        """
    def temperature_deg_c(self, z_world_m: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    def velocity_m_s(
        self, points_world_m: typing.Any, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the velocity (n, 3) at points (n, 3), including currents and waves.
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
    def compressible(self) -> bool:
        """
        whether pressure includes the compression of the water by its own weight (EOS-80)
        """
    @compressible.setter
    def compressible(self, arg0: bool) -> None: ...
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
        None for uniform density and salinity, with temperature linear down to bottom_depth_m
        """
    @profile.setter
    def profile(self, arg1: WaterProfile | None) -> None: ...
    @property
    def salinity_psu(self) -> float: ...
    @salinity_psu.setter
    def salinity_psu(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def sound_speed_equation(self) -> str:
        """
        unesco, del_grosso, belogolskii, leroy, mackenzie or medwin; assign "automatic" for the best. Raises
        ValueError if the water in its present state exceeds the equation's range.
        """
    @sound_speed_equation.setter
    def sound_speed_equation(self, arg1: str) -> None: ...
    @property
    def surface_temperature_deg_c(self) -> float: ...
    @surface_temperature_deg_c.setter
    def surface_temperature_deg_c(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tide_bound_m(self) -> float:
        """
        bound of the tide's height above or below z = 0; 0 without a tide
        """
    @property
    def waves(self) -> Waves | None:
        """
        None for a flat surface
        """
    @waves.setter
    def waves(self, arg1: Waves | None) -> None: ...

class RoundShape:
    """
    A sphere or a straight piece of round pipe, on which ray hits are exact, without facets.
    """
    @staticmethod
    def cylinder(
        start_world_m: typing.Any, end_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex
    ) -> RoundShape:
        """
        Return a cylinder between two points (3,) on its axis, with flat caps. Raises ValueError.
        """
    @staticmethod
    def pipe(line_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex) -> list[RoundShape]:
        """
        Return pieces of pipe along a line (n, 3), with caps at both ends and mitred bends. Raises ValueError.
        """
    @staticmethod
    def sphere(centre_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex) -> RoundShape:
        """
        Return a sphere about centre_world_m (3,). Raises ValueError.
        """
    @property
    def radius_m(self) -> float: ...

class World:
    """
    The world that dynamics and rays share. ENU, z up, water surface at z = 0.
    """

    water: Water
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...
    def add_cover(
        self,
        name: str,
        meshes: collections.abc.Sequence[tuple[typing.Any, typing.Any]],
        stance: str = "upright",
        sunk: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        density_per_m2: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        size_m: tuple[typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex] = (
            0.1,
            0.1,
        ),
        size_exponent: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        depth_m: tuple[typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex] = ...,
        slope_rad: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = ...,
        from_solids_m: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = ...,
        patch_m: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        patch_share: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        seed: typing.SupportsInt | typing.SupportsIndex = 0,
        solid: bool = False,
        drag_coefficient: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        leans_at_m_s: typing.SupportsFloat | typing.SupportsIndex = ...,
    ) -> int:
        """
        Add a layer of pieces on the terrain and return its label; solids must be added before. meshes: pairs
        (vertices (n, 3), triangles (m, 3)) with the origin on the bed and the largest extent 1. stance:
        upright, on_bed or tumbled. The other values are as in CoverLayer (cpp/uwsim/world/cover.h). Raises
        ValueError.
        """
    def add_plume(
        self,
        name: str,
        count: typing.SupportsInt | typing.SupportsIndex,
        shapes: collections.abc.Sequence[collections.abc.Sequence[tuple[typing.Any, typing.Any]]],
        source_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        top_z_m: typing.SupportsFloat | typing.SupportsIndex,
        drift_m_s: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        seed: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        Add a plume of bubbles after all schools. shapes: for each part of the way up, the meshes (vertices (n, 3),
        triangles (m, 3)) that a cluster may have there. source_m: where it begins. top_z_m: where it ends. drift_m_s:
        of the water. Raises ValueError.
        """
    def add_school(
        self,
        name: str,
        count: typing.SupportsInt | typing.SupportsIndex,
        shapes: collections.abc.Sequence[collections.abc.Sequence[tuple[typing.Any, typing.Any]]],
        position_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        round_m: typing.SupportsFloat | typing.SupportsIndex,
        speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
        spread_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        stroke_hz: typing.SupportsFloat | typing.SupportsIndex,
        clear_m: typing.SupportsFloat | typing.SupportsIndex,
        seed: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        Add a school of fish. shapes: for each size, the meshes (vertices (n, 3), triangles (m, 3)) of a fish in each
        phase of a stroke, x ahead and z up. The other values are as in SchoolSpec (cpp/uwsim/world/school.h). Raises
        ValueError.
        """
    def add_solid(
        self,
        name: str,
        vertices_world_m: typing.Any,
        triangles: typing.Any,
        shapes: collections.abc.Sequence[RoundShape] = [],
    ) -> int:
        """
        Add a solid and return its label. vertices_world_m: (n, 3) float64; triangles: (m, 3) indices. shapes:
        rays hit these instead of the mesh, which is then used for contacts and as the reference surface.
        Raises ValueError.
        """
    def height_at(self, xy_m: typing.Any) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the height (n,) float64 of the terrain at positions (n, 2); NaN outside.
        """
    def school_at(
        self, school: typing.SupportsInt | typing.SupportsIndex, time_s: typing.SupportsFloat | typing.SupportsIndex
    ) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Return where the fish of a school are at a time: positions (n, 3) [m] and unit vectors ahead (n, 3).
        Raises ValueError.
        """
    def set_terrain(
        self, heights_m: typing.Any, spacing_m: typing.SupportsFloat | typing.SupportsIndex, origin_m: typing.Any
    ) -> None:
        """
        Set the terrain. heights_m: (ny, nx) float32, where heights_m[j, i] is z at (x0 + i spacing, y0 + j
        spacing). origin_m: (x0, y0). Raises ValueError for wrong shapes, non-finite heights or an invalid
        spacing.
        """
    def solid_around(
        self, point_world_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]
    ) -> str | None:
        """
        Return the name of a closed solid that encloses the point (3,), or None.
        """
    def surface_mesh(
        self, with_terrain: bool = True
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint32], numpy.typing.NDArray[numpy.uint16]
    ]:
        """
        Return (vertices_world_m (n, 3) float64, triangles (m, 3) uint32, labels (m,) uint16) of the terrain,
        if requested, and of all solids.
        """
    def with_water(self, water: Water) -> World:
        """
        Return a world in different water that shares this world's terrain and solids.
        """
    @property
    def highest_m(self) -> float:
        """
        Height of the terrain's highest point; -inf without terrain.
        """
    @property
    def label_names(self) -> list[str]:
        """
        Names by label: nothing, terrain, then the names of the solids and the layers of cover.
        """
    @property
    def lowest_m(self) -> float:
        """
        Height of the terrain's lowest point; -inf without terrain.
        """
    @property
    def terrain_extent_m(self) -> tuple[float, float, float, float]:
        """
        (x0, y0, x1, y1) [m]
        """

class FixedWater(Water):
    """
    The water of a running simulator: Water that cannot be changed.
    """
    def __setattr__(self, name: str, value: typing.Any) -> None: ...
    def add_current(self, current: Current) -> None:
        """
        Raise AttributeError.
        """
    @property
    def current_world_m_s(self) -> numpy.ndarray:
        """
        (3,), read-only.
        """
    @current_world_m_s.setter
    def current_world_m_s(self, arg1: typing.Any) -> None: ...

class FixedWorld(World):
    """
    The world of a running simulator: a World that cannot be changed.
    """
    def __init__(self, world: World) -> None: ...
    def __setattr__(self, name: str, value: typing.Any) -> None: ...
    def add_cover(
        self,
        name: str,
        meshes: collections.abc.Sequence[tuple[typing.Any, typing.Any]],
        stance: str = "upright",
        sunk: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        density_per_m2: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        size_m: tuple[typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex] = (
            0.1,
            0.1,
        ),
        size_exponent: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        depth_m: tuple[typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex] = ...,
        slope_rad: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = ...,
        from_solids_m: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = ...,
        patch_m: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        patch_share: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        seed: typing.SupportsInt | typing.SupportsIndex = 0,
        solid: bool = False,
        drag_coefficient: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        leans_at_m_s: typing.SupportsFloat | typing.SupportsIndex = ...,
    ) -> int:
        """
        Raise AttributeError.
        """
    def add_plume(
        self,
        name: str,
        count: typing.SupportsInt | typing.SupportsIndex,
        shapes: collections.abc.Sequence[collections.abc.Sequence[tuple[typing.Any, typing.Any]]],
        source_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        top_z_m: typing.SupportsFloat | typing.SupportsIndex,
        drift_m_s: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        seed: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        Raise AttributeError.
        """
    def add_school(
        self,
        name: str,
        count: typing.SupportsInt | typing.SupportsIndex,
        shapes: collections.abc.Sequence[collections.abc.Sequence[tuple[typing.Any, typing.Any]]],
        position_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        round_m: typing.SupportsFloat | typing.SupportsIndex,
        speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
        spread_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        stroke_hz: typing.SupportsFloat | typing.SupportsIndex,
        clear_m: typing.SupportsFloat | typing.SupportsIndex,
        seed: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        Raise AttributeError.
        """
    def add_solid(
        self,
        name: str,
        vertices_world_m: typing.Any,
        triangles: typing.Any,
        shapes: collections.abc.Sequence[RoundShape] = [],
    ) -> int:
        """
        Raise AttributeError.
        """
    def set_terrain(
        self, heights_m: typing.Any, spacing_m: typing.SupportsFloat | typing.SupportsIndex, origin_m: typing.Any
    ) -> None:
        """
        Raise AttributeError.
        """
    @property
    def water(self) -> Water:
        """
        Read-only.
        """
    @water.setter
    def water(self, arg1: Water) -> None: ...

class SurfaceSampler:
    """
    Samples the parts of a world's terrain and solids that lie inside a polygon and a box.
    """
    def __init__(
        self,
        world: World,
        resolution_m: typing.SupportsFloat | typing.SupportsIndex,
        area_world_m: typing.Any,
        low_m: typing.Any,
        high_m: typing.Any,
    ) -> None:
        """
        area_world_m: (k, 2), a simple polygon. low_m, high_m: (3,), the box, which may be infinite. Raises
        ValueError.
        """
    def sample(
        self,
        first: typing.Annotated[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], "FixedSize(3)"],
        end: typing.Annotated[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], "FixedSize(3)"],
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.int64]
    ]:
        """
        Sample the voxels floor(x / resolution_m) from first up to, but excluding, end: (3,) integers, at most
        512 per side. Returns points (n, 3) float64, sorted by voxel, at most one per octant of a voxel; the
        voxel of each point, (n,) int64; and the voxels (v, 3) int64, sorted. Releases the GIL. Raises
        ValueError.
        """
    @property
    def box_m(
        self,
    ) -> (
        tuple[
            typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"],
            typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"],
        ]
        | None
    ):
        """
        Corners (3,) of a box that encloses all surface to be sampled; None if there is none.
        """
    @property
    def voxels_in_box(self) -> float:
        """
        Approximate number of voxels in that box that the surface passes through.
        """

class RayHits:
    @property
    def labels(self) -> numpy.typing.NDArray[numpy.uint16]:
        """
        (n,) uint16, see World.label_names; vehicles follow
        """
    @property
    def normals_world(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (n, 3) float32, unit; zero if nothing was hit
        """
    @property
    def ranges_m(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (n,) float32; inf if nothing was hit within range
        """

class RayScene:
    """
    The world's surfaces, prepared for rays (Embree). A snapshot: solids added later are not included.
    Vehicles are included only in the scene returned by Simulation.scene_around.
    """
    def __init__(self, world: World) -> None: ...
    def __repr__(self) -> str: ...
    def cast(
        self,
        origins_m: typing.Any,
        directions: typing.Any,
        max_range_m: typing.SupportsFloat | typing.SupportsIndex,
        exact: bool = True,
    ) -> RayHits:
        """
        Cast rays. origins_m: (n, 3) or (1, 3); directions: (n, 3), of any nonzero length. exact: False for
        pictures: in float and faster, with errors in distance of about 1e-4 m. Returns RayHits. Raises
        ValueError.
        """
    def cover_in(
        self,
        low_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[2, 1]"],
        high_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[2, 1]"],
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.uint16],
        numpy.typing.NDArray[numpy.uint32],
    ]:
        """
        Return the pieces of cover whose origins lie between two corners (2,) of an area: positions_world_m
        (n, 3), sizes_m (n,), labels (n,) and numbers (n,), as in Picture.pieces. Releases the GIL.
        """
    def distance_m(self, points_m: typing.Any) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the distances (n,) float64 from points (n, 3) to the nearest triangle, exact to double rounding.
        """
    def prepare(self) -> None:
        """
        Build Embree's trees of the fixed surfaces, unless they exist. Without this call, the first ray builds them.
        Raises ValueError if there is not enough memory.
        """
    def seen_groups(
        self,
        viewpoints_m: typing.Any,
        points_m: typing.Any,
        group_of_point: typing.Any,
        group_count: typing.SupportsInt | typing.SupportsIndex,
        range_m: typing.SupportsFloat | typing.SupportsIndex,
        tolerance_m: typing.SupportsFloat | typing.SupportsIndex = 0.001,
    ) -> numpy.typing.NDArray[numpy.bool]:
        """
        Return, for each group, whether one of its points is visible from one of viewpoints_m (v, 3): within
        range_m, with no surface more than tolerance_m in front of it, (group_count,) bool. points_m: (n, 3);
        group_of_point: (n,), sorted. Raises ValueError.
        """
    def visible(
        self,
        origin_m: typing.Any,
        points_m: typing.Any,
        tolerance_m: typing.SupportsFloat | typing.SupportsIndex = 0.001,
    ) -> numpy.typing.NDArray[numpy.bool]:
        """
        Return whether points are visible from origin_m (3,), with no surface more than tolerance_m in front
        of them, (n,) bool.
        """

class VoxelScene:
    """
    Cubes, such as a map's occupied voxels, prepared for the rays of pictures. The cubes lie at multiples
    of edge_m.
    """
    def __init__(self, centres_world_m: typing.Any, edge_m: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        centres_world_m: (n, 3), less than 2^17 cubes apart. Raises ValueError.
        """
    def cast(
        self, origins_m: typing.Any, directions: typing.Any, max_range_m: typing.SupportsFloat | typing.SupportsIndex
    ) -> RayHits:
        """
        Like RayScene.cast; labels are 0. A ray that starts inside a cube hits it at distance 0.
        """

class SurfaceVoxels:
    """
    Determines the distances of voxel centres from the true surface, and whether the surface passes through
    the voxels. Results are cached, so that a map can be scored while it grows.
    """
    def __init__(self, rays: RayScene, resolution_m: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        rays: RayScene of the world. Voxels are floor(x / resolution_m) on each axis. Raises ValueError.
        """
    def __len__(self) -> int:
        """
        The number of voxels that have been examined.
        """
    def distances_m(self, voxels: typing.Any) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the distances from voxel centres to the nearest triangle, (n,) float64, exact to double
        rounding. voxels: (n,) int64, packed as by uwsim.mapping.voxel_keys. Voxels that have already been
        examined take less time. Uses all threads. Releases the GIL. Raises ValueError.
        """
    def hold_surface(self, voxels: typing.Any, distances_m: typing.Any) -> numpy.typing.NDArray[numpy.bool]:
        """
        Return whether the surface passes through voxels, or within 1 mm of them, (n,) bool, given their
        distances (n,). Uses all threads. Releases the GIL. Raises ValueError.
        """
    def look_at(self, points_world_m: typing.Any) -> None:
        """
        Examine the voxels that contain points (n, 3), in advance of `distances_m`. Releases the GIL. Raises
        ValueError.
        """
    @property
    def resolution_m(self) -> float: ...

class SoundSpeedProfile:
    """
    Speed of sound by depth: linear between levels, constant above and below them.
    """
    @staticmethod
    def even(speed_m_s: typing.SupportsFloat | typing.SupportsIndex) -> SoundSpeedProfile:
        """
        Return a profile with the same speed at all depths, in which rays are straight.
        """
    def __init__(self, depths_m: typing.Any, speeds_m_s: typing.Any) -> None:
        """
        Create a profile from two arrays (n,), with increasing depths. Raises ValueError naming the level.
        """
    def at(self, depth_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Return the speed [m/s] at a depth [m].
        """

class Arrival:
    """
    Sound that arrives along one ray; see cpp/uwsim/acoustics/arrivals.h.
    """
    @property
    def arrival_dip_rad(self) -> float:
        """
        below the horizontal, in the direction of travel
        """
    @property
    def bottom_bounces(self) -> int: ...
    @property
    def launch_dip_rad(self) -> float:
        """
        below the horizontal
        """
    @property
    def length_m(self) -> float: ...
    @property
    def level_db(self) -> float:
        """
        relative to the source's level at 1 m
        """
    @property
    def phase_rad(self) -> float: ...
    @property
    def surface_bounces(self) -> int: ...
    @property
    def time_s(self) -> float: ...
    @property
    def turns(self) -> int: ...

class SonarParameters:
    """
    Parameters of an active sonar: transmitter, receiver and detector. Levels re 1 uPa (at 1 m).
    """
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raise ValueError naming the field if a parameter is invalid.
        """
    def range_cell_m(self, sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    @property
    def bandwidth_hz(self) -> float: ...
    @bandwidth_hz.setter
    def bandwidth_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def beam_width_across_rad(self) -> float:
        """
        -3 dB width, one way, of a receiving beam, within the fan's plane
        """
    @beam_width_across_rad.setter
    def beam_width_across_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def beam_width_along_rad(self) -> float:
        """
        -3 dB width, one way, of the transmitter, across the fan's plane
        """
    @beam_width_along_rad.setter
    def beam_width_along_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def detection_threshold_db(self) -> float:
        """
        signal-to-noise ratio at which a single look is detected half of the time
        """
    @detection_threshold_db.setter
    def detection_threshold_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def directivity_index_db(self) -> float: ...
    @directivity_index_db.setter
    def directivity_index_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def frequency_hz(self) -> float: ...
    @frequency_hz.setter
    def frequency_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def lossless_snr_db(self) -> float:
        """
        SL + processing gain + DI - NL
        """
    @property
    def noise_level_db(self) -> float:
        """
        noise level in the receiver's band
        """
    @noise_level_db.setter
    def noise_level_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def processing_gain_db(self) -> float:
        """
        10 log10 (bandwidth x pulse length)
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
    The acoustic backscattering properties of a bottom.
    """
    def __getstate__(self) -> tuple[float, float, typing.Any, typing.Any, typing.Any]: ...
    def __init__(
        self,
        strength_db: typing.SupportsFloat | typing.SupportsIndex = -30.0,
        relief: typing.SupportsFloat | typing.SupportsIndex = 0.1,
        seabed: str | None = None,
        fluid: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
        ] = [1.9, 1.1, 0.8],
        ripples_rad: typing.SupportsFloat | typing.SupportsIndex | None = None,
    ) -> None:
        """
        Create a material. seabed: one of seabeds(), whose backscatter by angle replaces Lambert's law. fluid: the
        density and speed of sound relative to water, and the attenuation [dB per wavelength], by which it reflects
        sound that bounces more than once. ripples_rad: direction across ripples of sand, from x to y. Raises
        ValueError for an unknown seabed.
        """
    def __setstate__(self, arg0: tuple[float, float, typing.Any, typing.Any, typing.Any]) -> None: ...
    @property
    def fluid(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        density and speed of sound relative to water, attenuation [dB per wavelength]
        """
    @property
    def relief(self) -> float:
        """
        rms slope of the relief across a footprint
        """
    @property
    def ripples_rad(self) -> float | None:
        """
        direction across ripples of sand, from x to y, or None
        """
    @property
    def seabed(self) -> str | None:
        """
        the seabed whose backscatter by angle replaces Lambert's law, or None
        """
    @property
    def strength_db(self) -> float:
        """
        backscatter per square metre at normal incidence; other angles follow Lambert's law
        """

class CraftParameters:
    """
    Mass and hydrodynamic coefficients in Fossen's order: surge, sway, heave, roll, pitch, yaw.
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
    def buoyancy_share(self) -> list[float]:
        """
        buoyancy as a fraction of rho(z) g V, at depths from 0 in equal steps; if empty, 1
        """
    @buoyancy_share.setter
    def buoyancy_share(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def buoyancy_share_step_m(self) -> float: ...
    @buoyancy_share_step_m.setter
    def buoyancy_share_step_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
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
    def coefficients_volume_m3(self) -> float:
        """
        The submerged volume at which added mass and damping hold; 0: that of the whole hull.
        """
    @coefficients_volume_m3.setter
    def coefficients_volume_m3(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def crossflow_length_m(self) -> float:
        """
        The length along x over which the drag in sway and heave is spread; 0: at the origin.
        """
    @crossflow_length_m.setter
    def crossflow_length_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
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
    def munk_share(self) -> float:
        """
        The fraction of the Munk moment that remains; 1 in an ideal fluid.
        """
    @munk_share.setter
    def munk_share(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def quadratic_damping(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 6]"]:
        """
        (6, 6) [N s^2/m^2, N m s^2/rad^2]
        """
    @quadratic_damping.setter
    def quadratic_damping(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 6]"]) -> None: ...

class Craft:
    """
    A rigid body in a fluid: equations of motion after Fossen 2011, ch. 6 and 8.
    """
    def __init__(
        self,
        parameters: CraftParameters,
        vertices_body_m: typing.Any,
        triangles: typing.Any,
        division: typing.SupportsInt | typing.SupportsIndex | None = None,
    ) -> None:
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
        Return nu' (6,) under the actuators' wrench tau_body (6,).
        """
    def kinetic_energy_j(self, state: BodyState) -> float:
        """
        Return the kinetic energy of the body and the still water around it.
        """
    def submerged_fraction(
        self, state: BodyState, water: Water | None = None, time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0
    ) -> float:
        """
        Return the submerged fraction, from 0 (dry) to 1 (fully submerged). Without water, that below z = 0.
        """
    @property
    def volume_m3(self) -> float:
        """
        The volume that the hull displaces when submerged.
        """

class ThrustCurve:
    """
    Thrust in still water as a function of a command in [-1, 1], linear between points.
    """
    def __init__(
        self,
        commands: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        thrusts_n: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        path: str = "thrust_curve",
    ) -> None:
        """
        Create a curve. Raises ValueError unless commands increase, thrusts never decrease and command 0 maps
        to 0 N.
        """
    def command(self, thrust_n: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Return a command that produces this thrust.
        """
    def thrust_n(self, command: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
    @property
    def highest_n(self) -> float: ...
    @property
    def lowest_n(self) -> float: ...

class ThrusterSheet:
    """
    A thruster's performance in still water at one supply voltage.
    """
    def __init__(
        self,
        voltage_v: typing.SupportsFloat | typing.SupportsIndex,
        commands: typing.Any,
        thrusts_n: typing.Any,
        currents_a: typing.Any,
        rpm: typing.Any,
    ) -> None: ...
    @property
    def voltage_v(self) -> float: ...

class ThrusterSheets:
    """
    Thrust, current and revolutions by command and supply voltage, between measured sheets.
    """
    def __init__(self, sheets: collections.abc.Sequence[ThrusterSheet], path: str = "sheets") -> None:
        """
        Raises ValueError unless voltages and commands increase, command 0 gives 0 N and no current is negative.
        """
    def at(
        self,
        command: typing.SupportsFloat | typing.SupportsIndex,
        voltage_v: typing.SupportsFloat | typing.SupportsIndex,
    ) -> tuple[float, float, float]:
        """
        Thrust [N], current [A] and revolutions [1/min]. Raises ValueError beyond the sheets' voltages.
        """
    @property
    def voltages_v(self) -> list[float]: ...

class BatterySpec:
    """
    Cells with a voltage that falls with charge and load.
    """
    def __init__(self) -> None: ...
    @property
    def capacity_ah(self) -> float: ...
    @capacity_ah.setter
    def capacity_ah(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def charges(self) -> list[float]:
        """
        fractions of the capacity, from 0 to 1
        """
    @charges.setter
    def charges(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def cutoff_v(self) -> float:
        """
        below this voltage it switches off
        """
    @cutoff_v.setter
    def cutoff_v(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def hotel_w(self) -> float:
        """
        power of everything but the thrusters
        """
    @hotel_w.setter
    def hotel_w(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def initial_charge(self) -> float:
        """
        fraction
        """
    @initial_charge.setter
    def initial_charge(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def open_circuit_v(self) -> list[float]:
        """
        at each charge, at rest
        """
    @open_circuit_v.setter
    def open_circuit_v(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def resistance_ohm(self) -> float: ...
    @resistance_ohm.setter
    def resistance_ohm(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class ThrusterParameters:
    """
    A propeller and its motor, body frame.
    """
    def __init__(self, name: str, position_body_m: typing.Any, axis_body: typing.Any, curve: ThrustCurve) -> None: ...
    @property
    def axis_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) unit, direction of a positive thrust
        """
    @property
    def bollard_coefficient(self) -> float:
        """
        K_T at zero speed
        """
    @bollard_coefficient.setter
    def bollard_coefficient(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def counter_body_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"] | None:
        """
        (3,), where the opposite of a vertical force acts [m]; None: nowhere
        """
    @counter_body_m.setter
    def counter_body_m(self, arg1: typing.Any) -> None: ...
    @property
    def curve(self) -> ThrustCurve: ...
    @property
    def diameter_m(self) -> float: ...
    @diameter_m.setter
    def diameter_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def health(self) -> float:
        """
        fraction of the thrust that remains after a fault; the allocation does not account for it
        """
    @health.setter
    def health(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def is_vertical(self) -> bool:
        """
        a force along the world's vertical: buoyancy or weight
        """
    @is_vertical.setter
    def is_vertical(self, arg0: bool) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def position_body_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        position of the hub (3,) [m]
        """
    @property
    def sheets(self) -> ThrusterSheets:
        """
        for a supply whose voltage varies
        """
    @sheets.setter
    def sheets(self, arg0: ThrusterSheets) -> None: ...
    @property
    def spin(self) -> int:
        """
        1 right-handed, -1 left-handed about the axis when thrusting ahead
        """
    @spin.setter
    def spin(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def time_constant_s(self) -> float:
        """
        of the thrust; 0 for no lag
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
    def ventilates(self) -> bool:
        """
        draws air near the surface
        """
    @ventilates.setter
    def ventilates(self, arg0: bool) -> None: ...
    @property
    def zero_thrust_advance_ratio(self) -> float:
        """
        inf if thrust does not decrease with speed
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
        Return dC_L / d alpha at zero lift [1/rad].
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
        Oswald efficiency factor
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
        centre of pressure (3,) [m]
        """
    @property
    def rate_max_rad_s(self) -> float: ...
    @rate_max_rad_s.setter
    def rate_max_rad_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def slipstream_of(self) -> str:
        """
        name of a thruster; none if empty
        """
    @slipstream_of.setter
    def slipstream_of(self, arg0: str) -> None: ...
    @property
    def span_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,) unit; deflections are right-handed about it
        """
    @property
    def stall_angle_rad(self) -> float: ...
    @stall_angle_rad.setter
    def stall_angle_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def stall_sharpness_rad(self) -> float: ...
    @stall_sharpness_rad.setter
    def stall_sharpness_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class Windage:
    """
    What a wind meets of a hull that floats (Fossen 2011, sec. 8.1).
    """
    def __init__(self) -> None: ...
    @property
    def dry_volume_m3(self) -> float:
        """
        of the hull above the water as it floats
        """
    @dry_volume_m3.setter
    def dry_volume_m3(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def frontal_area_m2(self) -> float: ...
    @frontal_area_m2.setter
    def frontal_area_m2(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def height_m(self) -> float:
        """
        of the areas' centre above the body's origin
        """
    @height_m.setter
    def height_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def lateral_area_m2(self) -> float: ...
    @lateral_area_m2.setter
    def lateral_area_m2(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def length_m(self) -> float: ...
    @length_m.setter
    def length_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def speed_share(self) -> float:
        """
        the wind at that height, relative to that at 10 m
        """
    @speed_share.setter
    def speed_share(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def surge(self) -> float:
        """
        c_x
        """
    @surge.setter
    def surge(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def sway(self) -> float:
        """
        c_y
        """
    @sway.setter
    def sway(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def yaw(self) -> float:
        """
        c_n
        """
    @yaw.setter
    def yaw(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class ActuatorsSpec:
    """
    The thrusters and fins of a vehicle.
    """
    def __init__(self) -> None: ...
    @property
    def fins(self) -> list[FinParameters]: ...
    @fins.setter
    def fins(self, arg0: collections.abc.Sequence[FinParameters]) -> None: ...
    @property
    def full_wrench_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        (6,) direct force and torque along and about the axes at full effort, without thrusters [N, N m]
        """
    @full_wrench_body.setter
    def full_wrench_body(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"]) -> None: ...
    @property
    def thrusters(self) -> list[ThrusterParameters]: ...
    @thrusters.setter
    def thrusters(self, arg0: collections.abc.Sequence[ThrusterParameters]) -> None: ...

class AutopilotGains:
    """
    Gains in full effort per unit of error.
    """
    def __init__(
        self,
        *,
        speed: typing.SupportsFloat | typing.SupportsIndex,
        speed_integral: typing.SupportsFloat | typing.SupportsIndex,
        heading: typing.SupportsFloat | typing.SupportsIndex,
        heading_rate: typing.SupportsFloat | typing.SupportsIndex,
        height: typing.SupportsFloat | typing.SupportsIndex,
        height_rate: typing.SupportsFloat | typing.SupportsIndex,
        height_integral: typing.SupportsFloat | typing.SupportsIndex,
        level: typing.SupportsFloat | typing.SupportsIndex,
        level_rate: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class Autopilot:
    """
    Maintains heading, horizontal velocity and height, and keeps the vehicle level, without a model of it.
    """

    gains: AutopilotGains
    def __init__(self, period_s: typing.SupportsFloat | typing.SupportsIndex, gains: AutopilotGains) -> None: ...
    def steer(
        self,
        pose: typing.Any,
        velocity: typing.Any,
        heading_rad: typing.SupportsFloat | typing.SupportsIndex,
        velocity_world_m_s: typing.Any,
        z_world_m: typing.SupportsFloat | typing.SupportsIndex,
    ) -> tuple[float, float, float, float, float, float]:
        """
        Return the efforts of one control period, surge to yaw, each in [-1, 1]. pose has world_from_body (4,
        4); velocity has linear_body_m_s (3,) and angular_body_rad_s (3,). Raises ValueError for other shapes.
        """
    @property
    def integrals(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        Integrals of surge, sway and height (3,), in units of effort.
        """
    @integrals.setter
    def integrals(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...

class PidGains:
    def __init__(
        self,
        *,
        proportional: typing.SupportsFloat | typing.SupportsIndex,
        integral: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        derivative: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        filter_s: typing.SupportsFloat | typing.SupportsIndex = 0.1,
        tracking_s: typing.SupportsFloat | typing.SupportsIndex = 1.0,
    ) -> None: ...

class Pid:
    """
    A PID controller with a filtered derivative and anti-windup by back-calculation.
    """
    def __init__(self) -> None: ...
    def output(
        self,
        error: typing.SupportsFloat | typing.SupportsIndex,
        measured: typing.SupportsFloat | typing.SupportsIndex,
        gains: PidGains,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
    ) -> float: ...
    def settle(
        self,
        applied: typing.SupportsFloat | typing.SupportsIndex,
        gains: PidGains,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Complete the period with the output that the actuators actually delivered.
        """
    @property
    def derivative(self) -> float: ...
    @property
    def integral(self) -> float: ...

class ControlModel:
    """
    A controller's model of its vehicle, in deep, still water.
    """
    def __init__(
        self,
        craft: Craft,
        actuators: ActuatorsSpec,
        density_kg_m3: typing.SupportsFloat | typing.SupportsIndex,
        gravity_m_s2: typing.SupportsFloat | typing.SupportsIndex = 9.80665,
    ) -> None: ...
    def effort(
        self,
        wrench_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        surge_m_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        Return the efforts (6,) for a reachable wrench (6,).
        """
    def reachable(
        self,
        wrench_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        surge_m_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        across_first: bool = False,
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        Return the part of a requested wrench (6,) that thrusters, and fins at the given speed ahead, can
        deliver. Torque takes priority over force; both keep their direction. With across_first, force across
        the vehicle takes priority over force along it.
        """
    def wrench_body(
        self,
        world_from_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"],
        velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        Return the wrench (6,) for an acceleration (6,) at a rotation (3, 3) and velocity (6,), in body axes.
        """
    @property
    def driven(self) -> typing.Annotated[list[bool], "FixedSize(6)"]:
        """
        For each axis, surge to yaw, whether thrusters or fins drive it.
        """

class LoopGains:
    """
    The cascade of one axis: position, velocity, acceleration.
    """
    def __init__(
        self,
        *,
        position_1_s: typing.SupportsFloat | typing.SupportsIndex,
        velocity_1_s: typing.SupportsFloat | typing.SupportsIndex,
        integral_1_s2: typing.SupportsFloat | typing.SupportsIndex,
        acceleration_1: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class ControlGains:
    """
    Gains and limits of all loops.
    """
    def __init__(
        self,
        *,
        loops: typing.Annotated[collections.abc.Sequence[LoopGains], "FixedSize(6)"],
        filter_s: typing.SupportsFloat | typing.SupportsIndex,
        tracking_s: typing.SupportsFloat | typing.SupportsIndex,
        speed_max_m_s: typing.SupportsFloat | typing.SupportsIndex,
        climb_max_m_s: typing.SupportsFloat | typing.SupportsIndex,
        turn_max_rad_s: typing.SupportsFloat | typing.SupportsIndex,
        acceleration_max_m_s2: typing.SupportsFloat | typing.SupportsIndex,
        turn_acceleration_max_rad_s2: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class MotionController:
    """
    Position, depth, heading, attitude and velocity control.
    """
    def __init__(
        self, model: ControlModel, gains: ControlGains, period_s: typing.SupportsFloat | typing.SupportsIndex
    ) -> None:
        """
        Create a controller. Raises ValueError for invalid gains.
        """
    def hold_velocity(
        self,
        pose: typing.Any,
        velocity: typing.Any,
        velocity_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
    ) -> tuple[float, float, float, float, float, float]:
        """
        Return the efforts of one control period for maintaining a velocity (6,) in body axes, [m/s] and
        [rad/s].
        """
    def reach(
        self,
        pose: typing.Any,
        velocity: typing.Any,
        position_world_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        velocity_world_m_s: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        roll_rad: typing.SupportsFloat | typing.SupportsIndex,
        pitch_rad: typing.SupportsFloat | typing.SupportsIndex,
        heading_rad: typing.SupportsFloat | typing.SupportsIndex,
        across_first: bool = False,
    ) -> tuple[float, float, float, float, float, float]:
        """
        Return the efforts of one control period for reaching a position (3,) that moves at a velocity (3,);
        positions that are NaN are not controlled. across_first: see ControlModel.reachable. pose, velocity:
        see Autopilot.steer.
        """
    @property
    def force_share(self) -> float:
        """
        The fraction of the requested force that the thrusters delivered in the last period.
        """
    @property
    def memory(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        The state (25,) carried from one period to the next, which can be saved.
        """
    @memory.setter
    def memory(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[25, 1]"]) -> None: ...

class Guidance:
    """
    Guidance along a path from a given position.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def along_m(self) -> float:
        """
        distance travelled along the path
        """
    @property
    def course_rad(self) -> float:
        """
        direction of the commanded velocity, from the world's x axis, counter-clockwise
        """
    @property
    def cross_track_m(self) -> float:
        """
        distance from the path, positive to port
        """
    @property
    def is_done(self) -> bool:
        """
        whether the end has been passed
        """
    @property
    def left_m(self) -> float:
        """
        remaining distance to the path's end
        """
    @property
    def path_rad(self) -> float:
        """
        direction of the path segment
        """
    @property
    def z_world_m(self) -> float:
        """
        height of the path abeam of the vehicle
        """

class PathFollower:
    """
    Line-of-sight guidance along straight segments.
    """
    def __init__(
        self,
        points_m: typing.Any,
        lookahead_m: typing.SupportsFloat | typing.SupportsIndex,
        integral_m_s: typing.SupportsFloat | typing.SupportsIndex,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        points_m: (n, 3), at least two vertices. Raises ValueError.
        """
    def guide(self, position_world_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> Guidance:
        """
        Return guidance for one control period.
        """
    def pace(
        self,
        course_rad: typing.SupportsFloat | typing.SupportsIndex,
        speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
        force_share: typing.SupportsFloat | typing.SupportsIndex,
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[2, 1]"]:
        """
        Adapt the pace for one control period to the share of the force that the thrusters delivered, and return
        the velocity over ground (2,) along a course.
        """
    @property
    def integral_s(self) -> float: ...
    @integral_s.setter
    def integral_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def segment(self) -> int: ...
    @segment.setter
    def segment(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...

class SensorKind:
    """
    A kind of sensor.
    """
    @property
    def channels(self) -> dict[str, tuple[int, str]]:
        """
        {name: (width, unit)} of the quantities to which noise is added
        """
    @property
    def fields(self) -> dict[str, tuple[int, str]]:
        """
        {name: (width, unit)} of a reading's fields
        """
    @property
    def meaning(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict[str, Parameter]:
        """
        {name: Parameter}
        """

class NoiseSpec:
    """
    Errors of one channel of a sensor, in its unit u: white noise (std per sample, density in u per root
    hertz), turn_on_std, a Gauss-Markov bias (bias_std, bias_time_s), walk (u per root second), instability (flicker noise), quantum,
    limits. 0 disables an error.
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
        instability: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        quantum: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        limit_low: typing.SupportsFloat | typing.SupportsIndex = ...,
        limit_high: typing.SupportsFloat | typing.SupportsIndex = ...,
    ) -> None: ...
    @property
    def bias_std(self) -> float: ...
    @property
    def bias_time_s(self) -> float: ...
    @property
    def density(self) -> float: ...
    @property
    def flicker_std(self) -> float:
        """
        standard deviation of the flicker noise
        """
    @property
    def instability(self) -> float:
        """
        the flat part of the Allan deviation
        """
    @property
    def limit_high(self) -> float: ...
    @property
    def limit_low(self) -> float: ...
    @property
    def quantum(self) -> float: ...
    @property
    def std(self) -> float: ...
    @property
    def turn_on_std(self) -> float: ...
    @property
    def walk(self) -> float: ...

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
        parameters: of the kind; noise: by channel; rate_hz: 0 for every step. Validated by
        Simulation.add_vehicle.
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
    def noise(self) -> dict[str, NoiseSpec]:
        """
        {channel: NoiseSpec} of the channels with errors.
        """
    @property
    def orientation_xyzw(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"]:
        """
        (4,), body from sensor
        """
    @property
    def parameters(self) -> dict[str, list[float]]:
        """
        {name: values} of the kind's parameters, including defaults.
        """
    @property
    def position_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        position on the body (3,)
        """
    @property
    def rate_hz(self) -> float: ...

class SensorReading:
    """
    One sample of a sensor.
    """
    @property
    def stamp_ns(self) -> int:
        """
        time of the measurement
        """
    @property
    def valid(self) -> bool: ...
    @property
    def values(self) -> dict[str, typing.Any]:
        """
        {field: float or (n,) float64}
        """

class MultibeamModel:
    """
    A multibeam's fan: beams evenly spaced about the head's forward axis.
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
        receiver_tilt_rad: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        gain_db: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        Create a model. Raises ValueError naming the field.
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
    def gain_db(self) -> float:
        """
        of the receiver's display; added to every intensity
        """
    @property
    def name(self) -> str: ...
    @property
    def number(self) -> int:
        """
        1..4 in messages; 0 for a model that messages cannot select
        """
    @property
    def ping_rate_max_hz(self) -> float:
        """
        limit of the electronics
        """
    @property
    def range_limit_m(self) -> float:
        """
        limit of the published decoder: a range above this counts as no echo
        """
    @property
    def range_max_m(self) -> float:
        """
        a range at or beyond this counts as no echo
        """
    @property
    def receiver_tilt_rad(self) -> float:
        """
        angle of each of two receivers from straight ahead to its side; 0 for a single receiver
        """
    @property
    def tilt_rate_rad_s(self) -> float: ...

class Detection:
    """
    The method by which a beam's range was detected.

    Members:

      NONE

      AMPLITUDE

      PHASE

      FALSE : noise detected as an echo
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
    One multibeam ping in physics mode: the arrays of Ping and more, read-only, with one value per beam.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def _repr_png_(self) -> typing.Any: ...
    def plot(self) -> typing.Any:
        """
        Return a matplotlib Figure of this object.
        """
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
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
    def deviation_m(self) -> numpy.ndarray:
        """
        (beams,) float32, standard deviation of the range, by the detector's own estimate; inf = no detection
        """
    @property
    def horizontal_deviation_m(self) -> numpy.ndarray:
        """
        (beams,) float32, the same for the echo's horizontal position
        """
    @property
    def incidence_rad(self) -> numpy.ndarray:
        """
        (beams,) float32 in [0, pi/2], true value; NaN for no detection, a false one, a ghost or a target in the
        water
        """
    @property
    def intensity_db(self) -> numpy.ndarray:
        """
        (beams,) float32, received level minus source level, with speckle and noise; -inf for no detection
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (beams,) uint16, true value, see World.label_names; 0 for no detection, a false one, a ghost or a target
        in the water
        """
    @property
    def model(self) -> int:
        """
        EM 2040 variant 1..4; 0 for a model that messages cannot select
        """
    @property
    def points_sonar_m(self) -> numpy.ndarray:
        """
        (beams, 3) float32, the range along the beam's axis; NaN for no detection
        """
    @property
    def ranges_m(self) -> numpy.ndarray:
        """
        (beams,) float32, sound speed at the head x half the travel time; inf for no detection
        """
    @property
    def snr_db(self) -> numpy.ndarray:
        """
        (beams,) float32, signal-to-noise ratio at the detector; -inf for no detection
        """
    @property
    def time_ns(self) -> int: ...
    @property
    def travel_time_s(self) -> numpy.ndarray:
        """
        (beams,) float32, two-way; inf for no detection
        """
    @property
    def valid(self) -> numpy.ndarray:
        """
        (beams,) bool: detected, including false detections
        """
    @property
    def vertical_deviation_m(self) -> numpy.ndarray:
        """
        (beams,) float32, standard deviation of the echo's height in the world, due to the error of its range
        and the transmitter's width; inf = no detection
        """
    @property
    def water_column(self) -> typing.Any:
        """
        (beams, samples) float32 [dB], the level of each sample in the units of intensity_db, with speckle
        and noise; None unless requested. At most 4096 samples per beam, each of one or several range cells
        """
    @property
    def water_column_ranges_m(self) -> typing.Any:
        """
        (samples,) float32, the middle of each sample; None unless requested
        """
    @property
    def world_from_sonar(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]:
        """
        (4, 4) float64, at transmission
        """

class WaterTargets:
    """
    A school of fish, or the rising bubbles of a seep, as point targets.
    """
    def __init__(
        self,
        name: str,
        rises: bool,
        position_m: typing.Any,
        size_m: typing.Any,
        count: typing.SupportsInt | typing.SupportsIndex,
        target_strength_db: typing.SupportsFloat | typing.SupportsIndex,
        rise_m_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        Create a group. A school fills an ellipsoid around position_m with the diameters size_m. The bubbles of
        a seep (rises) form a cone with its tip at position_m; size_m is its diameters at the top and its
        height. target_strength_db: of each target, re 1 m^2. Raises ValueError.
        """
    @property
    def count(self) -> int: ...
    @property
    def name(self) -> str: ...

class AcousticSpec:
    """
    The acoustic parameters of a multibeam in physics mode.
    """

    false_detections: bool
    parameters: SonarParameters
    range_noise: bool
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raise ValueError naming the field if a parameter is invalid.
        """
    @property
    def acidity_ph(self) -> float: ...
    @acidity_ph.setter
    def acidity_ph(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bending(self) -> bool:
        """
        Whether rays follow the sound-speed profile.
        """
    @bending.setter
    def bending(self, arg0: bool) -> None: ...
    @property
    def bottom(self) -> BottomMaterial:
        """
        for labels that `materials` does not cover
        """
    @bottom.setter
    def bottom(self, arg0: BottomMaterial) -> None: ...
    @property
    def materials(self) -> list[BottomMaterial]:
        """
        by label, see World.label_names
        """
    @materials.setter
    def materials(self, arg0: collections.abc.Sequence[BottomMaterial]) -> None: ...
    @property
    def multipath(self) -> bool:
        """
        Whether echoes with several bounces are received.
        """
    @multipath.setter
    def multipath(self, arg0: bool) -> None: ...
    @property
    def rays_per_beam(self) -> int:
        """
        rays per beam: 1, or 4 to 64
        """
    @rays_per_beam.setter
    def rays_per_beam(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def targets(self) -> list[WaterTargets]:
        """
        fish and bubbles in the water
        """
    @targets.setter
    def targets(self, arg0: collections.abc.Sequence[WaterTargets]) -> None: ...
    @property
    def volume_strength_db(self) -> float | None:
        """
        backscatter per cubic metre of water [dB]; None for none
        """
    @volume_strength_db.setter
    def volume_strength_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex | None) -> None: ...

class AcousticMultibeam:
    """
    A multibeam in physics mode, independent of any vehicle. Pings do not depend on the number of threads.
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
        Create a sonar. Raises ValueError naming the field.
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
        time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        water_column: bool = False,
    ) -> PhysicsPing:
        """
        Ping once from a pose (3,), (4,), with linear and angular velocity (3,), (3,) in world axes. Random
        draws are keyed by tick; bubbles move with time_s. Raises ValueError. Releases the GIL.
        """
    @property
    def profile(self) -> SoundSpeedProfile:
        """
        sound-speed profile of its water
        """

class ImagingKind:
    """
    A kind of imaging sonar.
    """
    @property
    def meaning(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict[str, Parameter]:
        """
        {name: Parameter}: the shared acoustic parameters and those of the kind.
        """

class ImagingSonar:
    """
    An imaging sonar; see uwsim.instruments.sonars.imaging.
    """
    def __init__(
        self,
        kind: str,
        parameters: collections.abc.Mapping[str, typing.SupportsFloat | typing.SupportsIndex],
        strengths_db: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [],
        materials: collections.abc.Sequence[BottomMaterial] = [],
    ) -> None:
        """
        parameters: values by name, see ImagingKind.parameters. strengths_db: Lambert's strength by label; NaN
        selects the strength of the bottom or of solids. materials: by label; a material with a seabed scatters
        like that seabed, and all materials reflect sound that bounces more than once. Raises ValueError naming
        the parameter.
        """
    def absorption_db_m(self, water: Water, head_z_m: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        Absorption in the water at the head [dB/m].
        """
    def ping(
        self,
        scene: RayScene,
        water: Water,
        positions_m: typing.Any,
        orientations_xyzw: typing.Any,
        seed: typing.SupportsInt | typing.SupportsIndex,
        stream: str,
        first_ping: typing.SupportsInt | typing.SupportsIndex,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
        angles_rad: typing.Any = (),
        with_labels: bool = False,
    ) -> dict[str, numpy.typing.NDArray[numpy.float32]]:
        """
        Return the kind's float32 arrays by name, for pings from poses (n, 3) and (n, 4), world from sonar.
        angles_rad (m,): of a steered beam. Ping k has the number first_ping + k, which selects its noise.
        with_labels: also return the label of the surface with the strongest mean echo in each cell, 0 where no
        echo is above the noise. The result does not depend on the number of threads. Raises ValueError.
        Releases the GIL.
        """

class DepthCamera:
    """
    Parameters of a depth camera; see uwsim.instruments.sonars.depth_map.DepthMap.
    """
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raise ValueError if a parameter is invalid.
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

class WaterOptics:
    """
    The optical properties of water [1/m], each (3,): red, green, blue.
    """
    @staticmethod
    def jerlov(type: str) -> WaterOptics:
        """
        Return the water of a Jerlov type (sources in water_optics.h). Raises ValueError for an unknown type.
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
    Everything that determines the light: the water, the sun, the wind on the surface, and particles in
    the water.
    """
    def __init__(
        self,
        water: WaterOptics,
        sun_elevation_rad: typing.SupportsFloat | typing.SupportsIndex,
        sun_azimuth_rad: typing.SupportsFloat | typing.SupportsIndex,
        wind_m_s: typing.SupportsFloat | typing.SupportsIndex,
        wind_towards_rad: typing.SupportsFloat | typing.SupportsIndex,
        particles_per_m3: typing.SupportsFloat | typing.SupportsIndex,
        turbulence_k: typing.SupportsFloat | typing.SupportsIndex,
        fetch_m: typing.SupportsFloat | typing.SupportsIndex = ...,
    ) -> None: ...
    def level_irradiance_below(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        Return the irradiance of daylight (3,) on a level surface just below a flat water surface, in units of
        the sun's irradiance outside the atmosphere.
        """
    def sun_irradiance_below(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        Return the sun's part (3,) of level_irradiance_below.
        """
    @property
    def to_sun_below_world(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def to_sun_world(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def water(self) -> WaterOptics: ...

class FlatPort:
    """
    A flat window between the lens, in air, and the water.
    """
    def __init__(
        self,
        distance_m: typing.SupportsFloat | typing.SupportsIndex,
        thickness_m: typing.SupportsFloat | typing.SupportsIndex,
        refractive_index: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class Lens:
    """
    Distortion as in OpenCV and CameraInfo, in pixels; lens.h contains the equations.
    """
    def __init__(
        self,
        width: typing.SupportsInt | typing.SupportsIndex,
        height: typing.SupportsInt | typing.SupportsIndex,
        fx: typing.SupportsFloat | typing.SupportsIndex,
        fy: typing.SupportsFloat | typing.SupportsIndex,
        cx: typing.SupportsFloat | typing.SupportsIndex,
        cy: typing.SupportsFloat | typing.SupportsIndex,
        distortion: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [0.0, 0.0, 0.0, 0.0, 0.0],
        port: FlatPort | None = None,
    ) -> None:
        """
        distortion: k1, k2, p1, p2, k3 (plumb_bob), these and k4, k5, k6 (rational_polynomial), or k1, k2, k3,
        k4 (equidistant)
        """

class Camera:
    """
    A camera: lens and image sensor. Raises ValueError naming the field.
    """
    def __init__(
        self,
        name: str,
        lens: Lens,
        exposure: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        full_well: typing.SupportsFloat | typing.SupportsIndex = 8000.0,
        read_noise: typing.SupportsFloat | typing.SupportsIndex = 6.0,
        vignetting: typing.SupportsFloat | typing.SupportsIndex = 0.5,
        wobble_rad: typing.SupportsFloat | typing.SupportsIndex | None = None,
        shutter_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        readout_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    def ray_offsets_m(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (height, width, 2) float32: X and Y of the points where these rays, extended, meet Z = 0 in water; 0
        without a flat port.
        """
    def ray_table(self, distort: bool = True, in_water: bool = True) -> numpy.typing.NDArray[numpy.float32]:
        """
        Return X/Z and Y/Z of the ray through each pixel's centre, in the optical frame, (height, width, 2)
        float32.
        """
    @property
    def folded_pixels(self) -> int:
        """
        The number of pixels that no ray meets, because the distortion folds the image over.
        """
    @property
    def name(self) -> str: ...

class SpotLamp:
    """
    A spot lamp that shines along its x axis; an irradiance of 1 is 1e5 lx.
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
    A rendered picture as read-only arrays from one pass, rows from the top; see picture.h.
    """
    @property
    def classes(self) -> numpy.ndarray:
        """
        (H, W) uint8, see CameraScene.class_names
        """
    @property
    def depth_m(self) -> numpy.ndarray:
        """
        (H, W) float32 along the optical axis, inf if nothing is hit
        """
    @property
    def gain(self) -> float:
        """
        factor from radiance to exposed signal
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (H, W) uint16, see CameraScene.label_names
        """
    @property
    def normals_world(self) -> numpy.ndarray:
        """
        (H, W, 3) float32, 0 if nothing is hit
        """
    @property
    def packets(self) -> bytes:
        """
        The ray packets cast, in the format of tools/bench/native/embree_bare_rays, if recorded
        """
    @property
    def pieces(self) -> numpy.ndarray:
        """
        (H, W) uint32, the number of the piece of cover, else 0; (0, W) in a world without cover
        """
    @property
    def radiance(self) -> numpy.ndarray:
        """
        (H, W, 3) float32 before exposure, if requested
        """
    @property
    def rgb(self) -> numpy.ndarray:
        """
        (H, W, 3) uint8, sRGB; (0, W, 3) if only geometry was requested
        """

class CameraScene:
    """
    A snapshot of the world with its materials and textures, plus vehicles.
    """
    def __init__(self, world: World, rays: RayScene, seed: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def add_school(self, material: str, surface_class: str, colour: typing.Any = None) -> None:
        """
        Add the appearance of the world's next school of fish, after all vehicles. Raises ValueError.
        """
    def add_vehicle(
        self,
        name: str,
        vertices_body_m: typing.Any,
        triangles: typing.Any,
        material: str,
        colour: typing.Any = None,
        texture_image: typing.Any = None,
        texture_corners: typing.Any = None,
        texture_normals: typing.Any = None,
        surface_class: str = "vehicle",
    ) -> int:
        """
        Add a hull, vertices (n, 3) and triangles (m, 3), and return the vehicle's index. texture: as for
        set_appearance. Raises ValueError.
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
        lamps: collections.abc.Sequence[SpotLamp] = [],
        vehicle_positions_m: typing.Any = None,
        vehicle_orientations_xyzw: typing.Any = None,
        hidden_vehicle: typing.SupportsInt | typing.SupportsIndex | None = None,
        geometry_only: bool = False,
        keep_radiance: bool = False,
        record: bool = False,
        velocity_camera: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"] = ...,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
        colours_only: bool = False,
    ) -> Picture:
        """
        Render one picture; the camera's frame is x ahead, y left, z up. effects: names of the effects that are
        on. vehicle_positions_m (n, 3), vehicle_orientations_xyzw (n, 4): for all vehicles or none.
        velocity_camera: (6,), in the camera's frame [m/s, rad/s]. The bytes do not depend on the number of
        threads. Releases the GIL. Raises ValueError.
        """
    def ripple_slopes(
        self,
        optics: Optics,
        time_s: typing.SupportsFloat | typing.SupportsIndex,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
    ) -> numpy.typing.NDArray[numpy.float32]:
        """
        Return the slopes (n, n, 2) along x and y of the ripples of the wind at a time, by row along y and column
        along x, on a square of 6.4 m that repeats from the world's origin.
        """
    def set_appearance(
        self,
        label: typing.SupportsInt | typing.SupportsIndex,
        material: str,
        surface_class: str,
        colour: typing.Any = None,
        texture_image: typing.Any = None,
        texture_corners: typing.Any = None,
        texture_normals: typing.Any = None,
    ) -> None:
        """
        Set a solid's appearance. colour: (3,) albedo. texture_image: (H, W, 3) uint8 sRGB, or (H, W, 8) with normal,
        roughness and metalness of glTF 2.0; texture_corners: (triangles, 3, 2), from the lower left;
        texture_normals: (triangles, 3, 3), unit vectors along the first edge, across it and along the triangle's
        normal. Raises ValueError.
        """
    def set_cover_appearance(
        self,
        label: typing.SupportsInt | typing.SupportsIndex,
        material: str,
        surface_class: str,
        colour: typing.Any = None,
        texture_image: typing.Any = None,
        texture_corners: typing.Any = None,
        texture_normals: typing.Any = None,
    ) -> None:
        """
        Set the appearance of a layer of cover, as set_appearance; a new surface_class is added to class_names.
        Raises ValueError.
        """
    def set_ground(self, bed: str, steep: str, land: str) -> None:
        """
        Set the terrain's materials: under water, where it is steep, and above water. Raises ValueError.
        """
    def set_ripples(self, across_rad: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Set the direction across ripples of sand, from x to y.
        """
    def show_detail(self) -> None:
        """
        Show relief and patterns of fixed surfaces down to the footprint of a pixel.
        """
    def with_water(self, water: Water, seed: typing.SupportsInt | typing.SupportsIndex) -> CameraScene:
        """
        Return a scene with the same surfaces in different water, with a different seed.
        """
    @property
    def class_names(self) -> list[str]:
        """
        surface_class_names(), followed by the classes of cover.
        """
    @property
    def classes_by_label(self) -> list[int]:
        """
        The class of each label, as an index into class_names.
        """
    @property
    def label_names(self) -> list[str]:
        """
        World.label_names, followed by the vehicles.
        """

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
    The instruction set of the brick engine's kernels; results do not depend on it.

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
    The engine of a map, and its probabilities of hit, miss and clamping.
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
    ) -> None: ...

class OccupancyMap:
    """
    OctoMap's octree about an origin in the world.
    """
    @staticmethod
    def read(path: os.PathLike[str] | str | bytes, origin_world_m: typing.Any, options: MapOptions) -> OccupancyMap:
        """
        Read a .bt or .ot file. Raises OSError if it cannot be read, ValueError if it is not a valid OctoMap
        file. Releases the GIL.
        """
    def __init__(
        self, resolution_m: typing.SupportsFloat | typing.SupportsIndex, origin_world_m: typing.Any, options: MapOptions
    ) -> None: ...
    def bodies_blocked(
        self,
        points_body_m: typing.Any,
        positions_world_m: typing.Any,
        orientations_xyzw: typing.Any,
        unknown_blocks: bool,
    ) -> numpy.ndarray:
        """
        Return whether a body's points, (k, 3), are in occupied (or unknown) voxels in each pose, (n,) bool.
        positions_world_m: (n, 3). orientations_xyzw: (n, 4). Raises ValueError. Releases the GIL.
        """
    def bounds(self) -> typing.Any:
        """
        Return the low and high corners, (3,) float64 each, of the box around the known voxels; None if there are
        none. Releases the GIL.
        """
    def cast_rays(
        self,
        origins_world_m: typing.Any,
        directions_world: typing.Any,
        ignore_unknown: bool,
        max_range_m: typing.SupportsFloat | typing.SupportsIndex,
    ) -> tuple[numpy.typing.NDArray[numpy.int8], numpy.typing.NDArray[numpy.float64]]:
        """
        Cast rays through the map. origins_world_m, directions_world: (n, 3) float64. Returns where the rays
        end, (n,) int8: 1 in an occupied voxel, 0 at the maximum range or the cube's edge, -1 in an unknown
        voxel; and the centres of the last voxels, (n, 3) float64. Releases the GIL.
        """
    def cells(
        self, depth: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]
    ]:
        """
        Return the cubes at a depth of the tree, 1 to 16, in the form of leaves(). Releases the GIL.
        """
    def changed_occupancy(self) -> tuple[numpy.typing.NDArray[numpy.int16], numpy.typing.NDArray[numpy.uint8]]:
        """
        Return the voxels that became occupied, or are no longer occupied, since the last call: their offsets
        from the origin in voxels, (n, 3) int16, and whether they are occupied now, (n,) uint8. Releases the
        GIL.
        """
    def changed_voxels(self) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int8]]:
        """
        Return the voxels whose state has changed since the last call: centres (n, 3) float64, states (n,)
        int8. Releases the GIL.
        """
    def count(self) -> tuple[int, int]:
        """
        Return (occupied voxels, free voxels). Releases the GIL.
        """
    def free_voxels(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the centres of the free voxels, (n, 3) float64, world frame, at the finest level, in Morton
        order. Releases the GIL.
        """
    def insert_scan(
        self,
        points_world_m: typing.Any,
        origin_world_m: typing.Any,
        max_range_m: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Insert one ping. points_world_m: (n, 3) float32; NaN and inf are skipped. origin_world_m: (3,)
        float64. Raises ValueError, without inserting anything, for wrong shapes, a non-finite origin and
        points outside OctoMap's cube. Releases the GIL.
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
        Insert pings in order. points_world_m: (n, 3) float32, the points of all pings; counts: (m,) int64,
        the number of points in each; origins_world_m: (m, 3) float64. Raises ValueError like insert_scan,
        without inserting any ping. Releases the GIL.
        """
    def leaves(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]
    ]:
        """
        Return the leaves of the pruned tree: centres (n, 3) float64, edges (n,) float64, log-odds (n,)
        float32. Releases the GIL.
        """
    def log_odds_at(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.float32]:
        """
        Return the log-odds at points_world_m, (n, 3) float64, finite: (n,) float32, NaN where unknown.
        Releases the GIL.
        """
    def merge(self, other: OccupancyMap) -> None:
        """
        Add the log-odds of another map. Raises ValueError. Releases the GIL.
        """
    def model(self) -> tuple[float, float, float, float]: ...
    def occupied_voxels(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the centres of the occupied voxels, (n, 3) float64, world frame, at the finest level, in Morton
        order. Releases the GIL.
        """
    def set_model(
        self,
        hit: typing.SupportsFloat | typing.SupportsIndex,
        miss: typing.SupportsFloat | typing.SupportsIndex,
        clamping_min: typing.SupportsFloat | typing.SupportsIndex,
        clamping_max: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Set the probabilities for later scans. Raises ValueError. Releases the GIL.
        """
    def spheres_blocked(
        self, centres_world_m: typing.Any, radius_m: typing.SupportsFloat | typing.SupportsIndex, unknown_blocks: bool
    ) -> numpy.ndarray:
        """
        Return whether spheres touch occupied (or unknown) voxels, (n,) bool. Raises ValueError. Releases the
        GIL.
        """
    def state_at(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.int8]:
        """
        Return the state at points_world_m, (n, 3) float64, finite: (n,) int8, 1 occupied, 0 free, -1 unknown.
        Releases the GIL.
        """
    def states_in(
        self, low_world_m: typing.Any, high_world_m: typing.Any
    ) -> tuple[numpy.typing.NDArray[numpy.int8], typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]]:
        """
        Return the states of the voxels whose centres are in a box, (nx, ny, nz) int8: 1 occupied, 0 free, -1
        unknown. Also return the centre of the first voxel, (3,). Raises ValueError. Releases the GIL.
        """
    def statistics(self) -> tuple[int, int, int, int, int]:
        """
        Return (occupied voxels, free voxels, nodes, bytes of memory, discarded points). Releases the GIL.
        """
    def to_bytes(self, format: str) -> bytes:
        """
        Return the bytes of a 'bt' or 'ot' file. Releases the GIL.
        """
    def unknown_in_view_m3(
        self,
        positions_world_m: typing.Any,
        orientations_xyzw: typing.Any,
        horizontal_rad: typing.SupportsFloat | typing.SupportsIndex,
        vertical_rad: typing.SupportsFloat | typing.SupportsIndex,
        range_m: typing.SupportsFloat | typing.SupportsIndex,
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the volume of unknown voxels that a sensor in each pose would see, (n,) float64. Raises
        ValueError. Releases the GIL.
        """
    def voxels_in(
        self, low_world_m: typing.Any, high_world_m: typing.Any
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float32]
    ]:
        """
        Return the finest voxels whose centres are in a box, in the form of leaves(). low_world_m,
        high_world_m: (3,) float64. Releases the GIL.
        """
    def write(self, path: os.PathLike[str] | str | bytes, format: str) -> None:
        """
        Write a 'bt' or 'ot' file atomically. Raises OSError. Releases the GIL.
        """
    @property
    def engine(self) -> MapEngine: ...
    @property
    def origin_world_m(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def resolution_m(self) -> float: ...

class DistanceField:
    """
    Distances to the nearest occupied voxel in a box of a map, by dynamicEDT3D.
    """
    def __init__(
        self,
        map: OccupancyMap,
        low_world_m: typing.Any,
        high_world_m: typing.Any,
        *,
        max_distance_m: typing.SupportsFloat | typing.SupportsIndex,
        unknown_is_occupied: bool,
    ) -> None: ...
    def distance_m(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.float32]:
        """
        Return the distances at points (n, 3): (n,) float32. Releases the GIL.
        """
    def gradient(self, points_world_m: typing.Any) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the gradients at points (n, 3): (n, 3) float64. Releases the GIL.
        """
    def grid(self) -> numpy.typing.NDArray[numpy.float32]: ...
    def update(self, map: OccupancyMap) -> int:
        """
        Update the field from the map. Returns the number of voxels that changed. Releases the GIL.
        """
    @property
    def low_centre_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def shape(self) -> typing.Annotated[list[int], "FixedSize(3)"]: ...

class BiasModel:
    """
    The model of a bias: a constant drawn at the start, a Gauss-Markov drift and a random walk.
    """
    def __init__(
        self,
        *,
        turn_on_std: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        drift_std: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        drift_time_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        walk: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    @property
    def exists(self) -> bool:
        """
        whether there is such a bias at all
        """

class NavigationFilter:
    """
    An error-state Kalman filter (Sola 2017) for an IMU and its aids. Readings may arrive late and in any
    order: the result depends only on the readings and their times. World ENU; REP 103 body axes; lever
    arms from the IMU.
    """

    save_version: typing.ClassVar[int] = 9
    def __init__(
        self,
        *,
        imu_body_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        gravity_m_s2: typing.SupportsFloat | typing.SupportsIndex,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
        rate_std: typing.SupportsFloat | typing.SupportsIndex,
        force_std: typing.SupportsFloat | typing.SupportsIndex,
        rate_bias: BiasModel,
        force_bias: BiasModel,
        rate_limit: typing.SupportsFloat | typing.SupportsIndex = ...,
        force_limit: typing.SupportsFloat | typing.SupportsIndex = ...,
        averaging_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        gyroscope_scale: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = (0.0, 0.0),
        gyroscope_by_force: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = (0.0, 0.0),
        accelerometer_scale: tuple[
            typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex
        ] = (0.0, 0.0),
        body_from_imu: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"] = ...,
    ) -> None:
        """
        period_s: sampling period of the IMU. rate_std, force_std: white noise of a sample [rad/s, m/s2].
        rate_limit, force_limit: the largest magnitude that an axis can measure. averaging_s: the time before
        a sample over which its force is averaged; 0 for an instantaneous value. gyroscope_scale,
        gyroscope_by_force, accelerometer_scale: standard deviations of the elements on and off the diagonal of
        a constant matrix N, by which x + N y is measured for x, y being the rate, the force and the force. Its
        axes are the IMU's, which body_from_imu (3, 3) turns to the body's.
        """
    def add_acoustic_fix(
        self,
        lever_body_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        range_std: typing.SupportsFloat | typing.SupportsIndex,
        bearing_std: typing.SupportsFloat | typing.SupportsIndex,
        range_step: typing.SupportsFloat | typing.SupportsIndex,
        period_s: typing.SupportsFloat | typing.SupportsIndex,
        range_bias: BiasModel,
        scale: BiasModel,
        bearing_bias: BiasModel,
        station_std: typing.SupportsFloat | typing.SupportsIndex,
        station_bias: BiasModel,
    ) -> int:
        """
        Add an aid that measures the position relative to the station, world axes, then has that of the station itself
        [m]. station_std: white noise of the latter. range_step: that to which
        ranges are rounded, or 0 if their noise is larger. period_s: time between fixes. Its biases: of the range [m],
        its scale, two of the bearing [rad], and three of the station's place, as far as they exist.
        """
    def add_depth(
        self,
        lever_body_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        std: typing.SupportsFloat | typing.SupportsIndex,
        bias: BiasModel,
        wave_std: typing.SupportsFloat | typing.SupportsIndex,
        level_std: typing.SupportsFloat | typing.SupportsIndex,
        column_std: typing.SupportsFloat | typing.SupportsIndex,
    ) -> int:
        """
        Add an aid that measures the weight of the water above as a depth in surface water [m]. Standard deviations
        before the first reading: wave_std, of the head of the waves' pressure, which the filter then adapts;
        level_std, of the still surface [m]; column_std, of the column's mean density, relative to the surface's.
        0: it errs by nothing, ever. Its biases: the instrument's, two for the waves, level, its rate over that of
        M2, column.
        """
    def add_dock(
        self,
        position_std: typing.SupportsFloat | typing.SupportsIndex,
        attitude_std: typing.SupportsFloat | typing.SupportsIndex,
        velocity_std: typing.SupportsFloat | typing.SupportsIndex,
    ) -> int:
        """
        Add an aid that measures the pose of a vehicle that a dock holds at rest: position of the IMU, then
        orientation x, y, z, w, with constant errors [m, rad, m/s].
        """
    def add_doppler(
        self,
        beams_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"],
        lever_body_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        std: typing.SupportsFloat | typing.SupportsIndex,
        bias: BiasModel,
        scale: BiasModel,
        misalignment: BiasModel,
    ) -> int:
        """
        Add an aid that measures velocities along beams (n, 3), unit vectors [m/s]; NaN for a lost beam. scale:
        relative error of all; misalignment: small rotation of the beams [rad]. Its biases: of the beams, then
        scale (1) and misalignment (3) as far as they exist. Return its index, like all functions that add an aid.
        """
    def add_heading(
        self,
        axis_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        std: typing.SupportsFloat | typing.SupportsIndex,
        bias: BiasModel,
        iron_std: typing.SupportsFloat | typing.SupportsIndex,
        north_rad: typing.SupportsFloat | typing.SupportsIndex,
    ) -> int:
        """
        Add an aid that measures the angle of axis_body from east, counter-clockwise [rad].
        """
    def add_imu(self, times_ns: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], readings: typing.Any) -> None:
        """
        Add samples of the IMU. times_ns (n,) uint64; readings (n, 6): angular velocity, specific force, body
        axes.
        """
    def add_orientation(self, std: typing.SupportsFloat | typing.SupportsIndex, bias: BiasModel) -> int:
        """
        Add an aid that measures the orientation x, y, z, w, world from body.
        """
    def add_readings(
        self,
        aid: typing.SupportsInt | typing.SupportsIndex,
        times_ns: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64],
        arrivals_ns: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64],
        readings: typing.Any,
    ) -> None:
        """
        Add readings of an aid. times_ns, arrivals_ns (n,) uint64; readings (n, width).
        """
    def add_satellites(
        self,
        lever_body_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        horizontal_std: typing.SupportsFloat | typing.SupportsIndex,
        vertical_std: typing.SupportsFloat | typing.SupportsIndex,
        velocity_std: typing.SupportsFloat | typing.SupportsIndex,
        horizontal_bias: BiasModel,
        vertical_bias: BiasModel,
    ) -> int:
        """
        Add an aid that measures the position [m] and velocity [m/s] of a satellite receiver's antenna, world axes.
        """
    def add_silence(self, time_ns: typing.SupportsInt | typing.SupportsIndex) -> None:
        """
        Record that the IMU provided no samples until this time.
        """
    def catch_up(self) -> None:
        """
        Process the readings that have been added.
        """
    def counts(self, aid: typing.SupportsInt | typing.SupportsIndex) -> tuple[int, int]:
        """
        Return the numbers of scalars of an aid's readings that were used and that were outliers.
        """
    def first_bias(self, aid: typing.SupportsInt | typing.SupportsIndex) -> int:
        """
        Return the index of the first of an aid's biases in `covariance`.
        """
    def restore(self, bytes: bytes) -> None:
        """
        Restore a saved state. Raises ValueError for bytes that were not saved by a filter with the same aids.
        Their version, which is stored beside them, must be save_version.
        """
    def save(self) -> bytes: ...
    def start(
        self,
        *,
        time_ns: typing.SupportsInt | typing.SupportsIndex,
        position_world_m: typing.Any,
        orientation_xyzw: typing.Any,
        position_std_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        attitude_std_rad: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        velocity_world_m_s: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        velocity_std_m_s: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Start the filter, after all aids have been added. Discards all earlier readings.
        """
    @property
    def aid_biases(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]: ...
    @property
    def angular_body_rad_s(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,)
        """
    @property
    def covariance(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        Covariance (n, n) of the errors of position and velocity (world axes), attitude (body axes, rad), the
        biases of gyroscope and accelerometer (body axes), the elements of the IMU's matrices of which an error is
        stated, 9 each, row by row, and the biases of the aids; of the IMU's centre
        """
    @property
    def force_bias_m_s2(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def linear_body_m_s(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,), of the body's origin
        """
    @property
    def numbers(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (248,): time [s], position, quaternion x, y, z, w, linear and angular velocity as above, the rotation
        (3, 3) and the covariance of the first 15 errors, both row by row
        """
    @property
    def orientation_xyzw(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def position_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,), of the body's origin
        """
    @property
    def rate_bias_rad_s(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def time_ns(self) -> int:
        """
        time of the newest IMU sample
        """
    @property
    def too_late(self) -> int:
        """
        number of readings that arrived too late to be used
        """
    @property
    def world_from_body(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]:
        """
        (4, 4)
        """

class DynamicsEngine:
    """
    Members:

      UWSIM

      BULLET
    """

    BULLET: typing.ClassVar[DynamicsEngine]
    UWSIM: typing.ClassVar[DynamicsEngine]
    __members__: typing.ClassVar[dict[str, DynamicsEngine]]
    @typing.overload
    def __eq__(self, other: DynamicsEngine) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: DynamicsEngine) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class SimulationSpec:
    engine: DynamicsEngine
    def __init__(self) -> None: ...
    def carry_station(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        position_body_m: typing.Any,
        docked_m: typing.Any,
        docked_xyzw: typing.Any,
    ) -> None:
        """
        Let the station ride on a vehicle, in whose frame its position (3,) and the pose of what is docked are.
        """
    def set_wind(
        self,
        speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
        heading_rad: typing.SupportsFloat | typing.SupportsIndex,
        gusts: typing.Any,
    ) -> None:
        """
        Set the wind 10 m above the water, and where it blows. gusts: (n, 3), amplitude [m/s], angular frequency
        [rad/s] and phase [rad] of each harmonic.
        """
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
        strengths_db: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [],
        on: bool = True,
    ) -> None:
        """
        acoustics: selects physics mode; if None, geometry mode. strengths_db: backscatter at normal incidence
        by label, for geometry mode; further labels are rock. on: if False, the sonar tilts but receives
        nothing.
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

class JointKind:
    """
    Members:

      FIXED

      HINGE

      SLIDE
    """

    FIXED: typing.ClassVar[JointKind]
    HINGE: typing.ClassVar[JointKind]
    SLIDE: typing.ClassVar[JointKind]
    __members__: typing.ClassVar[dict[str, JointKind]]
    @typing.overload
    def __eq__(self, other: JointKind) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: JointKind) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class ArmLink:
    """
    A link of an arm, and the joint that holds it.
    """

    joint: JointKind
    name: str
    def __init__(self) -> None: ...
    def set_pose(self, position_m: typing.Any, orientation_xyzw: typing.Any) -> None:
        """
        Set the link's frame in its parent's, at zero.
        """
    def set_surface(self, vertices_m: typing.Any, triangles: typing.Any) -> None:
        """
        Set what light and sound meet: a closed mesh in the link's frame, (n, 3) and (m, 3).
        """
    @property
    def added_mass(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 6]"]:
        """
        (6, 6), at the link's origin
        """
    @added_mass.setter
    def added_mass(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 6]"]) -> None: ...
    @property
    def axis(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @axis.setter
    def axis(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...
    @property
    def centre_of_buoyancy_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @centre_of_buoyancy_m.setter
    def centre_of_buoyancy_m(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...
    @property
    def centre_of_mass_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @centre_of_mass_m.setter
    def centre_of_mass_m(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None: ...
    @property
    def coulomb_friction(self) -> float: ...
    @coulomb_friction.setter
    def coulomb_friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def fastest(self) -> float: ...
    @fastest.setter
    def fastest(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def friction(self) -> float | None: ...
    @friction.setter
    def friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex | None) -> None: ...
    @property
    def gear_ratio(self) -> float: ...
    @gear_ratio.setter
    def gear_ratio(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def highest(self) -> float: ...
    @highest.setter
    def highest(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def inertia_kg_m2(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        (3, 3), about the centre of mass
        """
    @inertia_kg_m2.setter
    def inertia_kg_m2(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"]) -> None: ...
    @property
    def linear_drag(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        (6,), at the centre of buoyancy
        """
    @linear_drag.setter
    def linear_drag(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"]) -> None: ...
    @property
    def lowest(self) -> float: ...
    @lowest.setter
    def lowest(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def mass_kg(self) -> float: ...
    @mass_kg.setter
    def mass_kg(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def parent(self) -> int | None:
        """
        index of an earlier link; None: the base
        """
    @parent.setter
    def parent(self, arg1: typing.SupportsInt | typing.SupportsIndex | None) -> None: ...
    @property
    def quadratic_drag(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        (6,), at the centre of buoyancy
        """
    @quadratic_drag.setter
    def quadratic_drag(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"]) -> None: ...
    @property
    def response_s(self) -> float: ...
    @response_s.setter
    def response_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def rotor_inertia_kg_m2(self) -> float: ...
    @rotor_inertia_kg_m2.setter
    def rotor_inertia_kg_m2(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def start(self) -> float: ...
    @start.setter
    def start(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def strongest(self) -> float:
        """
        of the motor, at the joint; 0: there is none
        """
    @strongest.setter
    def strongest(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def torque_per_ampere(self) -> float:
        """
        0: unknown
        """
    @torque_per_ampere.setter
    def torque_per_ampere(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def viscous_friction(self) -> float: ...
    @viscous_friction.setter
    def viscous_friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def volume_m3(self) -> float: ...
    @volume_m3.setter
    def volume_m3(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class ArmReading:
    """
    The joints of an arm; those that are fixed stay at zero.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def currents_a(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,); NaN where it is unknown
        """
    @property
    def motor_torques(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,), at the joints [N m or N]
        """
    @property
    def names(self) -> list[str]: ...
    @property
    def positions(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) [rad or m]
        """
    @property
    def speeds(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,) [rad/s or m/s]
        """

class Mechanism:
    """
    An articulated body on a base of its own: fixed, or a rigid body. For studies; a vehicle's
    arm is part of its file. Featherstone's articulated-body algorithm, see the page on theory.
    """
    def __init__(
        self,
        links: collections.abc.Sequence[ArmLink],
        step_s: typing.SupportsFloat | typing.SupportsIndex = 0.001,
        base_mass: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 6]"] | None = None,
    ) -> None:
        """
        base_mass: (6, 6) of the base about its origin, linear before angular [kg, kg m, kg m^2]; None: fixed.
        """
    def accelerations(
        self,
        torques: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        water: Water,
        wrench_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"] = ...,
    ) -> tuple[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"], list[float]]:
        """
        Return nu' of the base, (6,), and the joints' accelerations under these torques, without Coulomb friction
        and stops. wrench_world: (6,) on the base at its origin, along the world's axes [N, N m].
        """
    def command(
        self,
        joint: typing.SupportsInt | typing.SupportsIndex,
        position: typing.SupportsFloat | typing.SupportsIndex | None = None,
        speed: typing.SupportsFloat | typing.SupportsIndex | None = None,
        torque: typing.SupportsFloat | typing.SupportsIndex | None = None,
    ) -> None: ...
    def energy_j(self, water: Water) -> tuple[float, float]:
        """
        Return kinetic energy, and that of the links' height [J].
        """
    def momentum_base(self, water: Water) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        Return the momentum at the base's origin along its axes, (6,).
        """
    def place(
        self,
        joint: typing.SupportsInt | typing.SupportsIndex,
        position: typing.SupportsFloat | typing.SupportsIndex,
        speed: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    def reaction_base(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]:
        """
        Return the wrench of the links on the base at the start of the last step, along its axes, (6,).
        """
    def reading(self) -> ArmReading: ...
    def step(
        self,
        count: typing.SupportsInt | typing.SupportsIndex,
        water: Water,
        wrench_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"] = ...,
    ) -> None:
        """
        Advance by fixed steps.
        """
    def world_from_link(
        self, link: typing.SupportsInt | typing.SupportsIndex, water: Water
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]: ...
    @property
    def base(self) -> BodyState:
        """
        the base's BodyState
        """
    @base.setter
    def base(self, arg0: BodyState) -> None: ...

class AppliedWrench:
    """
    A wrench that something else exerts on a body, at its origin.
    """
    def __init__(
        self,
        wrench: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        in_world_axes: bool,
        from_tick: typing.SupportsInt | typing.SupportsIndex,
        until_tick: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        wrench: (6,) [N, N m], along the world's axes or the body's; it acts in the steps of these ticks, the
        last excluded.
        """

class BodyPath:
    """
    The motion of a body that nothing can push.
    """
    def __init__(
        self,
        breaks: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        curve_m: typing.Annotated[
            collections.abc.Sequence[typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 4]"]], "FixedSize(3)"
        ],
        times_s: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        progress: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 4]"],
        closed: bool,
        climbs: bool,
        turns: bool,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
    ) -> None:
        """
        breaks: (n + 1,), ascending, of the curve's parameter u. curve_m: x, y and z, each (n, 4): coefficients
        of 1, h, h^2 and h^3 in each piece, where h = u - break. times_s: (m + 1,) from 0, ascending. progress:
        (m, 4), u in powers of the time since the break. closed: it begins again after the last time. climbs: x
        is along the curve; otherwise along its horizontal part. turns: otherwise x keeps pointing east. position_m, orientation_xyzw: of the body in
        path axes. Raises ValueError.
        """
    def at(self, time_s: typing.SupportsFloat | typing.SupportsIndex) -> BodyState:
        """
        Return the BodyState at a time from 0 on.
        """

class ObjectSpec:
    """
    A loose body.
    """
    def __init__(
        self,
        name: str,
        craft: Craft,
        shape: CollisionShape,
        friction: typing.SupportsFloat | typing.SupportsIndex,
        restitution: typing.SupportsFloat | typing.SupportsIndex,
        start: BodyState,
        wrenches: collections.abc.Sequence[AppliedWrench] = [],
        path: BodyPath | None = None,
        links: collections.abc.Sequence[ArmLink] = [],
        round: RoundShape | None = None,
    ) -> None:
        """
        path: that it follows, from its own start. links: that joints hold on it; a path then stands still. round:
        the ball or drum, body frame, that the craft's mesh stands for: contacts are with it, without facets.
        """
    def carry(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        link: typing.SupportsInt | typing.SupportsIndex,
        position_m: typing.Any,
        orientation_xyzw: typing.Any,
        along_body: typing.Any,
        spring_j: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        Let a vehicle carry it at a pose in the vehicle's frame until it is released, when a spring of this energy
        pushes it along a unit vector (3,) of the vehicle's frame. link: index of the vehicle's fixed link with
        its mass and water.
        """

class TetherEnd:
    """
    Where a tether is fastened.
    """
    def __init__(
        self,
        point_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        body: typing.SupportsInt | typing.SupportsIndex | None = None,
    ) -> None:
        """
        point_m: (3,), in the frame of the vehicle or object with this index, or the world's.
        """

class TetherSpec:
    """
    A tether's parameters.
    """

    name: str
    second: TetherEnd
    def __init__(self) -> None: ...
    def tube(
        self,
    ) -> tuple[
        typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 3]"],
        typing.Annotated[numpy.typing.NDArray[numpy.uint32], "[m, 3]"],
    ]:
        """
        Return vertices [m] (n, 3) and triangles (m, 3) of one of them, along z from its origin.
        """
    @property
    def axial_damping_n_s(self) -> float: ...
    @axial_damping_n_s.setter
    def axial_damping_n_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def axial_stiffness_n(self) -> float: ...
    @axial_stiffness_n.setter
    def axial_stiffness_n(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bed_stiffness_pa_m(self) -> float: ...
    @bed_stiffness_pa_m.setter
    def bed_stiffness_pa_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bending_stiffness_n_m2(self) -> float: ...
    @bending_stiffness_n_m2.setter
    def bending_stiffness_n_m2(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def breaking_load_n(self) -> float: ...
    @breaking_load_n.setter
    def breaking_load_n(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def diameter_m(self) -> float: ...
    @diameter_m.setter
    def diameter_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def elements(self) -> int: ...
    @elements.setter
    def elements(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def fastest_m_s(self) -> float:
        """
        0: there is no winch
        """
    @fastest_m_s.setter
    def fastest_m_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def first(self) -> TetherEnd:
        """
        the winch's end
        """
    @first.setter
    def first(self, arg0: TetherEnd) -> None: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def length_m(self) -> float: ...
    @length_m.setter
    def length_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def longest_m(self) -> float:
        """
        0: the length
        """
    @longest_m.setter
    def longest_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def mass_kg_m(self) -> float: ...
    @mass_kg_m.setter
    def mass_kg_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def normal_added_mass(self) -> float: ...
    @normal_added_mass.setter
    def normal_added_mass(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def normal_drag(self) -> float: ...
    @normal_drag.setter
    def normal_drag(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def shortest_m(self) -> float:
        """
        0: one element
        """
    @shortest_m.setter
    def shortest_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def strongest_n(self) -> float: ...
    @strongest_n.setter
    def strongest_n(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tangential_added_mass(self) -> float: ...
    @tangential_added_mass.setter
    def tangential_added_mass(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tangential_drag(self) -> float: ...
    @tangential_drag.setter
    def tangential_drag(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tubes(self) -> int:
        """
        as targets for rays, each with a label
        """

class VehicleSpec:
    actuators: ActuatorsSpec
    craft: Craft
    docked: bool
    name: str
    shape: CollisionShape
    def __init__(self) -> None: ...
    def set_collision_pieces(self, pieces_body_m: collections.abc.Sequence[numpy.ndarray]) -> None:
        """
        Set the convex pieces, each given by its corners (n, 3), body frame [m], and the shape to PIECES.
        """
    def set_start(self, position_m: typing.Any, orientation_xyzw: typing.Any) -> None: ...
    @property
    def arm(self) -> list[ArmLink]:
        """
        its links, a list; copied; empty: it has no arm
        """
    @arm.setter
    def arm(self, arg0: collections.abc.Sequence[ArmLink]) -> None: ...
    @property
    def battery(self) -> BatterySpec | None:
        """
        None: the simulation's mission time
        """
    @battery.setter
    def battery(self, arg0: BatterySpec | None) -> None: ...
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
    @property
    def windage(self) -> Windage | None:
        """
        None: it feels no wind
        """
    @windage.setter
    def windage(self, arg0: Windage | None) -> None: ...
    @property
    def wrenches(self) -> list[AppliedWrench]:
        """
        what acts on it, by schedule; copied
        """
    @wrenches.setter
    def wrenches(self, arg0: collections.abc.Sequence[AppliedWrench]) -> None: ...

class Tape:
    """
    Rows that a simulation appends at multiples of periods; see tape.h.
    """
    def __init__(self) -> None: ...
    def add_motion(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, period_ns: typing.SupportsInt | typing.SupportsIndex
    ) -> int:
        """
        Add a track: position (3,) [m], orientation_xyzw (4,), linear and angular velocity (3,) each, in body
        axes, and the elevation [rad] of each sonar.
        """
    def add_sensor(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sensor: typing.SupportsInt | typing.SupportsIndex,
        period_ns: typing.SupportsInt | typing.SupportsIndex,
    ) -> int:
        """
        Add a track of what read_sensor returns.
        """
    def add_time(self, period_ns: typing.SupportsInt | typing.SupportsIndex) -> int:
        """
        Add a track of times without values.
        """

class Simulation:
    """
    A world with vehicles, which are identified by index, advanced by fixed steps.
    """
    def __init__(self, world: World, scene: RayScene, spec: SimulationSpec) -> None: ...
    def acoustic_ping(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
        water_column: bool = False,
    ) -> PhysicsPing:
        """
        Ping in physics mode. Raises ValueError in geometry mode. Releases the GIL.
        """
    def add_object(self, spec: ObjectSpec) -> int:
        """
        Add a loose body, after all vehicles, and return its index.
        """
    def add_tether(self, spec: TetherSpec) -> int:
        """
        Add a tether, after all vehicles and objects, lay it, and return its index. Raises ValueError.
        """
    def add_vehicle(self, spec: VehicleSpec) -> int:
        """
        Add a vehicle and return its index.
        """
    def aim(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        elevation_rad: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Set the elevation to which the head turns over time; positive is up. Raises ValueError.
        """
    def apply_object_wrench(
        self,
        object: typing.SupportsInt | typing.SupportsIndex,
        wrench: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        in_world_axes: bool,
        duration_s: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        See apply_wrench.
        """
    def apply_wrench(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        wrench: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
        in_world_axes: bool,
        duration_s: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Exert a wrench (6,) on a vehicle at its origin, besides those by schedule, for a duration, which may be
        inf, or until the next call. Raises ValueError.
        """
    def arm(self, body: typing.SupportsInt | typing.SupportsIndex) -> ArmReading:
        """
        Return the arm's ArmReading: of a vehicle or, after those, of an object. Raises ValueError.
        """
    def attach_tape(self, tape: Tape) -> None:
        """
        Write a tape, before a restart or detach_tape, at the end of each step at which it is due.
        """
    def attached_surfaces(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 7]"]:
        """
        Return those of links, and then where the tubes of all tethers are, (n, 7).
        """
    def battery(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> BatteryState: ...
    def change(self, water: Water, spec: SimulationSpec, vehicles: collections.abc.Sequence[VehicleSpec]) -> None:
        """
        Replace all parameters; all state is kept. vehicles: one spec per vehicle, in order; their start
        states are ignored. Raises ValueError without changing anything.
        """
    def collisions(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> int:
        """
        Return the number of times the vehicle has come into contact with anything.
        """
    def command_joints(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        positions: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
        speeds: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
        torques: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
    ) -> None:
        """
        Command joints from (name, value) pairs: positions [rad or m], speeds [per s], the motors' torques at the
        joints [N m or N]. The others keep their commands. Raises ValueError, changing nothing.
        """
    def command_winch(
        self,
        tether: typing.SupportsInt | typing.SupportsIndex,
        rate_m_s: typing.SupportsFloat | typing.SupportsIndex | None = None,
        tension_n: typing.SupportsFloat | typing.SupportsIndex | None = None,
    ) -> None:
        """
        Pay out at a rate, keep a tension, or, without either, hold. Raises ValueError.
        """
    def contacts(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[ContactForce]:
        """
        Return the points at which the vehicle was pressed in the last step. Raises ValueError.
        """
    def controllable(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[list[bool], "FixedSize(6)"]:
        """
        Return, for each axis, surge to yaw, whether an effort about it has an effect.
        """
    def currents_a(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        (name, present current [A]) pairs; 0 without a battery that has cells.
        """
    def cut_tether(
        self, tether: typing.SupportsInt | typing.SupportsIndex, at_m: typing.SupportsFloat | typing.SupportsIndex
    ) -> None:
        """
        Cut it at this length from the winch. Raises ValueError.
        """
    def detach_tape(self, tape: Tape) -> None: ...
    def dock(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        position_world_m: typing.Any,
        orientation_xyzw: typing.Any,
    ) -> None:
        """
        Hold the vehicle at this pose, at rest, with its commands cancelled and its battery full, until it is
        released. Raises ValueError.
        """
    def effort(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]: ...
    def fin_angles_rad(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        Return (name, present deflection [rad]) pairs of the fins that can be deflected.
        """
    def forces(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> list[tuple[str, typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]]]:
        """
        Return (name, wrench (6,)) pairs: means over the last step, body axes, at the origin [N, N m]. Raises
        ValueError with Bullet's engine.
        """
    def full_wrench_body(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> typing.Annotated[list[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]], "FixedSize(2)"]:
        """
        Return two arrays (6,): magnitudes of the largest wrench along or about each axis alone, forward and
        backward [N, N m].
        """
    def in_physics_mode(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> bool: ...
    def link_counts(
        self, topic: typing.SupportsInt | typing.SupportsIndex, from_node: typing.SupportsInt | typing.SupportsIndex
    ) -> TopicCounts: ...
    def link_cut_off(self, node: typing.SupportsInt | typing.SupportsIndex, is_cut_off: bool) -> None:
        """
        Disconnect a node from now on, or reconnect it.
        """
    def link_deliveries(
        self, to_node: typing.SupportsInt | typing.SupportsIndex, after_ns: typing.SupportsInt | typing.SupportsIndex
    ) -> list[LinkDelivery]:
        """
        Return the messages that arrived at a node after a time, oldest first; only the newest 512 of all
        nodes are kept.
        """
    def link_fault_loss(
        self, from_node: typing.SupportsInt | typing.SupportsIndex, to_node: typing.SupportsInt | typing.SupportsIndex
    ) -> float:
        """
        Return the probability that a fault destroys a packet sent now.
        """
    def link_next_arrival_ns(self) -> int:
        """
        Return a lower bound for the time at which the next message arrives.
        """
    def link_quality(
        self, from_node: typing.SupportsInt | typing.SupportsIndex, at_node: typing.SupportsInt | typing.SupportsIndex
    ) -> LinkQuality: ...
    def link_reception(
        self, from_node: typing.SupportsInt | typing.SupportsIndex, to_node: typing.SupportsInt | typing.SupportsIndex
    ) -> Reception:
        """
        Return how a packet sent now would be received.
        """
    def link_send(
        self,
        from_node: typing.SupportsInt | typing.SupportsIndex,
        to_node: typing.SupportsInt | typing.SupportsIndex,
        topic: typing.SupportsInt | typing.SupportsIndex,
        payload: bytes,
        priority: typing.SupportsInt | typing.SupportsIndex = 0,
        lifetime_s: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        replaces: bool = False,
        repeats: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> bool:
        """
        Queue a message now and return whether there was room. lifetime_s: time after which it is no longer
        sent; 0 for no limit. repeats: number of times that it is sent again. Raises ValueError.
        """
    def link_sending_s(self) -> float:
        """
        Return the total time that nodes have been sending [s].
        """
    def link_surfaces(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 7]"]:
        """
        Return where the links are that have a surface, of all vehicles in order: (n, 7), position [m] and
        quaternion x, y, z, w in the world.
        """
    def link_topic(self, name: str) -> int:
        """
        Return the index of a topic, creating it if it is new.
        """
    def link_topics(self) -> list[str]: ...
    def link_waiting(self, node: typing.SupportsInt | typing.SupportsIndex) -> tuple[int, int]:
        """
        Return (messages, bytes) in a node's queue.
        """
    def links_world(
        self, body: typing.SupportsInt | typing.SupportsIndex
    ) -> list[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]]:
        """
        Return world_from_link of each link, (4, 4), as for `arm`.
        """
    def load_object(self, object: typing.SupportsInt | typing.SupportsIndex) -> None:
        """
        Put an object back to where its vehicle carries it. Raises ValueError if it is there.
        """
    def motion(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
    ]:
        """
        Return the state as read-only arrays: position_world_m (3,), orientation_xyzw (4,), world_from_body
        (4, 4), linear_body_m_s (3,) and angular_body_rad_s (3,).
        """
    def object_contacts(self, object: typing.SupportsInt | typing.SupportsIndex) -> list[ContactForce]: ...
    def object_forces(
        self, object: typing.SupportsInt | typing.SupportsIndex
    ) -> list[tuple[str, typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 1]"]]]: ...
    def object_loaded(self, object: typing.SupportsInt | typing.SupportsIndex) -> bool:
        """
        Return whether a vehicle carries an object now.
        """
    def object_state(self, object: typing.SupportsInt | typing.SupportsIndex) -> BodyState: ...
    def object_wet_surface(
        self, object: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        See wet_surface.
        """
    def ping(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> Ping:
        """
        Ping in geometry mode. Releases the GIL.
        """
    def ping_batch(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        world_from_body: typing.Any,
        threads: typing.SupportsInt | typing.SupportsIndex | None = None,
    ) -> PingBatch:
        """
        Ping in geometry mode from each of world_from_body, (n, 4, 4) float64, rigid, with the head at its
        present elevation and the other vehicles at their present poses. threads: all by default; results do
        not depend on it. Raises ValueError. Releases the GIL. Can be interrupted by Ctrl-C.
        """
    def pings_together(
        self,
        sonars: collections.abc.Sequence[
            tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, bool]
        ],
        threads: typing.SupportsInt | typing.SupportsIndex,
    ) -> list[Ping | PhysicsPing]:
        """
        Ping with each of sonars, (vehicle, sonar, water_column), on several threads. Returns Pings, and
        PhysicsPings of sonars in physics mode. Releases the GIL.
        """
    def place_joint(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        joint: typing.SupportsInt | typing.SupportsIndex,
        position: typing.SupportsFloat | typing.SupportsIndex,
        speed: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        Move a joint immediately. Raises ValueError.
        """
    def read_sensor(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sensor: typing.SupportsInt | typing.SupportsIndex,
        with_noise: bool = True,
    ) -> SensorReading:
        """
        Read a sensor. Reading again at the same time returns the same sample. Without noise: the present
        value, without errors, rate, latency or drop-outs.
        """
    def release(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def release_object(self, object: typing.SupportsInt | typing.SupportsIndex) -> None:
        """
        Let go of an object that a vehicle carries. Raises ValueError unless it is loaded.
        """
    def released(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> bool: ...
    def restart(self, world: World, spec: SimulationSpec) -> None:
        """
        Restart with the same vehicles and objects at their start states. world: as before, except for its water. Raises
        ValueError without changing anything.
        """
    def restore_state(self, state: bytes, scenario: str, build: str) -> str:
        """
        Restore a saved state and return its notes. Raises ValueError, without changing anything, for a
        damaged state or other fingerprints.
        """
    def save_state(self, scenario: str, build: str, notes: str = "") -> bytes:
        """
        Return the complete state, as bytes, along with fingerprints of the simulation's parameters; the
        parameters themselves are not included. notes: stored as well.
        """
    def scene_around(self, vehicle: typing.SupportsInt | typing.SupportsIndex | None = None) -> RayScene:
        """
        Return the world with all vehicles and objects at their present poses, except the given vehicle. A
        snapshot. Labels of vehicles, then of objects and tethers, follow those of the world.
        """
    def set_effort(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        surge: typing.SupportsFloat | typing.SupportsIndex,
        sway: typing.SupportsFloat | typing.SupportsIndex,
        heave: typing.SupportsFloat | typing.SupportsIndex,
        roll: typing.SupportsFloat | typing.SupportsIndex,
        pitch: typing.SupportsFloat | typing.SupportsIndex,
        yaw: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Set the efforts, each in [-1, 1]. Raises ValueError.
        """
    def set_fins(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        angles_rad: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
    ) -> None:
        """
        Set fin deflections from (name, deflection [rad]) pairs; the others are centred. Raises ValueError.
        """
    def set_link(self, spec: LinkSpec) -> None:
        """
        Connect the station, node 0, and all vehicles, nodes 1 + index. May be called once. Raises ValueError.
        """
    def set_state(self, vehicle: typing.SupportsInt | typing.SupportsIndex, state: BodyState) -> None: ...
    def set_thrusters(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        commands: collections.abc.Sequence[tuple[str, typing.SupportsFloat | typing.SupportsIndex]],
    ) -> None:
        """
        Set thruster commands from (name, command in [-1, 1]) pairs; the others stop. Raises ValueError.
        """
    def set_wrench(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        wrench_body: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[6, 1]"],
    ) -> None:
        """
        Set the wrench (6,) [N, N m]; a wrench beyond the thrusters' limits is scaled down in its direction.
        Raises ValueError.
        """
    def sonar_elevation_rad(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> float:
        """
        Return the present elevation of the head.
        """
    def sonar_ping_rate_max_hz(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> float:
        """
        Return the maximum ping rate: the lower of the limit by two-way travel time, c / (2 range) with c at the
        head, and the limit of the electronics.
        """
    def sonar_target_elevation_rad(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> float:
        """
        Return the elevation to which the head turns.
        """
    def state(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> BodyState: ...
    def step(self, count: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        """
        Advance by fixed steps. Releases the GIL. Can be interrupted by Ctrl-C.
        """
    def take_rows(
        self, tape: Tape, track: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[
        numpy.typing.NDArray[numpy.uint64],
        numpy.typing.NDArray[numpy.uint64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.bool],
    ]:
        """
        Return stamps_ns (n,), times_ns (n,), values (n, width) and valid (n,) of a track since the last call.
        Raises IndexError.
        """
    def take_samples(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sensor: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[
        numpy.typing.NDArray[numpy.uint64],
        numpy.typing.NDArray[numpy.uint64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.bool],
    ]:
        """
        Return stamps_ns (n,), arrivals_ns (n,), readings (n, width) and valid (n,) of the samples that have
        arrived since the last call, except dropped ones. Raises ValueError unless the sensor is watched.
        """
    def telemetry(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> Telemetry: ...
    def tether(self, tether: typing.SupportsInt | typing.SupportsIndex) -> TetherReading: ...
    def thruster_commands(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        Return (name, command) pairs.
        """
    def thrusts_n(self, vehicle: typing.SupportsInt | typing.SupportsIndex) -> list[tuple[str, float]]:
        """
        Return (name, present still-water thrust [N]) pairs.
        """
    def watch_sensor(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sensor: typing.SupportsInt | typing.SupportsIndex,
        from_ns: typing.SupportsInt | typing.SupportsIndex | None,
    ) -> None:
        """
        Start collecting the samples measured at or after from_ns, as they arrive; None stops collecting.
        """
    def weaken_tether(
        self, tether: typing.SupportsInt | typing.SupportsIndex, load_n: typing.SupportsFloat | typing.SupportsIndex
    ) -> None:
        """
        From now on, break it also at this load, until a restart; states do not include it. Raises ValueError.
        """
    def wet_surface(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Return the corners (n, 3, 3) [m] of the triangles of the hull that are under water, those at the surface
        cut at it, and the force of the water's pressure on each (n, 3) [N]; body axes.
        """
    @property
    def tick(self) -> int: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def version(self) -> int:
        """
        A counter that changes whenever an observation may change: with time, a vehicle's pose or a sonar's
        elevation.
        """

class Telemetry:
    """
    A vehicle's instrument panel, as in the paper.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def acceleration_m_s2(self) -> float: ...
    @property
    def angular_acceleration_body_rad_s2(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,)
        """
    @property
    def angular_speed_rad_s(self) -> float: ...
    @property
    def battery_percent(self) -> float:
        """
        remaining fraction of the battery's charge or of the mission time
        """
    @property
    def collision_warning(self) -> bool: ...
    @property
    def depth_m(self) -> float:
        """
        straight up to the surface, with its waves and tide; negative above it
        """
    @property
    def distance_to_seabed_m(self) -> float:
        """
        straight down; inf if there is no surface below
        """
    @property
    def distance_to_station_m(self) -> float: ...
    @property
    def linear_acceleration_body_m_s2(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,), without gravity
        """
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

class BatteryState:
    """
    The readings of a battery's monitor; NaN for quantities of a mission time.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def capacity_ah(self) -> float:
        """
        of a full battery
        """
    @property
    def charge_ah(self) -> float:
        """
        what remains
        """
    @property
    def current_a(self) -> float:
        """
        out of the terminals
        """
    @property
    def percent(self) -> float:
        """
        remaining usable charge; 0 once the battery has switched off
        """
    @property
    def voltage_v(self) -> float:
        """
        at the terminals
        """

class ContactForce:
    """
    A point at which a body was pressed in the last step, and the force on it.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def force_world_n(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,), on the body itself; mean over the step
        """
    @property
    def link(self) -> str:
        """
        the link of the body's arm, or of an object's joints; empty: the body itself
        """
    @property
    def other(self) -> str:
        """
        the other body's name; empty for terrain and obstacles
        """
    @property
    def other_link(self) -> str:
        """
        likewise of the other body
        """
    @property
    def point_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        """
        (3,)
        """

class TetherReading:
    """
    A tether's shape, tension and length.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def broken(self) -> int | None:
        """
        the element that has broken, or None
        """
    @property
    def end_forces_n(self) -> list[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]]:
        """
        of the tether on what holds its ends, world axes, (2, 3)
        """
    @property
    def length_m(self) -> float:
        """
        out, without load
        """
    @property
    def points_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 3]"]:
        """
        (n + 1, 3): its nodes, from the winch
        """
    @property
    def rate_m_s(self) -> float:
        """
        paid out in the last step
        """
    @property
    def tensions_n(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
        """
        (n,): of its elements
        """

class Ping:
    """
    One multibeam ping. Arrays are read-only, with one value per beam. A ping that Sonar.ping() took also has
    `chain`, from pings to a map, and `world_from_body` (4, 4), which copies do not have.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def _repr_png_(self) -> typing.Any: ...
    def plot(self) -> typing.Any:
        """
        Return a matplotlib Figure of this object.
        """
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def angles_rad(self) -> numpy.ndarray:
        """
        (beams,) float32, about the sonar's +z, positive to port
        """
    @property
    def incidence_rad(self) -> numpy.ndarray:
        """
        (beams,) float32 in [0, pi/2], NaN for no echo
        """
    @property
    def intensity_db(self) -> numpy.ndarray:
        """
        (beams,) float32, echo level minus source level (Lambert, 40 log R, absorption); -inf for no echo
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (beams,) uint16, see Simulator.label_names
        """
    @property
    def model(self) -> int:
        """
        EM 2040 variant 1..4; 0 for another sonar
        """
    @property
    def points_sonar_m(self) -> numpy.ndarray:
        """
        (beams, 3) float32, NaN for no echo
        """
    @property
    def ranges_m(self) -> numpy.ndarray:
        """
        (beams,) float32, inf for no echo
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
    Several pings of one sonar. Arrays are read-only, with one row per ping; see Ping.
    """
    def __copy__(self) -> typing.Any: ...
    def __deepcopy__(self, memo: typing.Any) -> typing.Any: ...
    def __getstate__(self) -> dict[str, typing.Any]: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: dict[str, typing.Any]) -> None: ...
    def to_dict(self) -> dict[str, typing.Any]:
        """
        Return the fields by name; arrays are not copied.
        """
    @property
    def angles_rad(self) -> numpy.ndarray:
        """
        (beams,) float32, common to all pings
        """
    @property
    def incidence_rad(self) -> numpy.ndarray:
        """
        (n, beams) float32 in [0, pi/2], NaN for no echo
        """
    @property
    def intensity_db(self) -> numpy.ndarray:
        """
        (n, beams) float32, -inf for no echo
        """
    @property
    def labels(self) -> numpy.ndarray:
        """
        (n, beams) uint16
        """
    @property
    def model(self) -> int:
        """
        EM 2040 variant 1..4; 0 for another sonar
        """
    @property
    def points_sonar_m(self) -> numpy.ndarray:
        """
        (n, beams, 3) float32, NaN for no echo
        """
    @property
    def ranges_m(self) -> numpy.ndarray:
        """
        (n, beams) float32, inf for no echo
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

class LinkKind:
    """
    Members:

      CABLE

      IDEAL

      MODEM
    """

    CABLE: typing.ClassVar[LinkKind]
    IDEAL: typing.ClassVar[LinkKind]
    MODEM: typing.ClassVar[LinkKind]
    __members__: typing.ClassVar[dict[str, LinkKind]]
    @typing.overload
    def __eq__(self, other: LinkKind) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: LinkKind) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class MediumAccess:
    """
    Members:

      ALOHA

      TDMA
    """

    ALOHA: typing.ClassVar[MediumAccess]
    TDMA: typing.ClassVar[MediumAccess]
    __members__: typing.ClassVar[dict[str, MediumAccess]]
    @typing.overload
    def __eq__(self, other: MediumAccess) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: MediumAccess) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class Modulation:
    """
    Members:

      PSK

      FSK
    """

    FSK: typing.ClassVar[Modulation]
    PSK: typing.ClassVar[Modulation]
    __members__: typing.ClassVar[dict[str, Modulation]]
    @typing.overload
    def __eq__(self, other: Modulation) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: Modulation) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class ModemSpec:
    """
    Parameters of a modem; see cpp/uwsim/acoustics/modem/modem_spec.h.
    """

    access: MediumAccess
    fading: bool
    kind: LinkKind
    modulation: Modulation
    def __init__(self) -> None: ...
    def check(self) -> None:
        """
        Raise ValueError naming modem.<field> if a parameter is invalid.
        """
    def packet_s(self, bytes: typing.SupportsInt | typing.SupportsIndex) -> float:
        """
        Return the duration of a packet [s].
        """
    @property
    def acknowledgement_bytes(self) -> int: ...
    @acknowledgement_bytes.setter
    def acknowledgement_bytes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def backoff_s(self) -> float: ...
    @backoff_s.setter
    def backoff_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bandwidth_hz(self) -> float: ...
    @bandwidth_hz.setter
    def bandwidth_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def bit_rate_bit_s(self) -> float: ...
    @bit_rate_bit_s.setter
    def bit_rate_bit_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def coding_gain_db(self) -> float: ...
    @coding_gain_db.setter
    def coding_gain_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def frequency_hz(self) -> float: ...
    @frequency_hz.setter
    def frequency_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def guard_s(self) -> float: ...
    @guard_s.setter
    def guard_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def header_bytes(self) -> int: ...
    @header_bytes.setter
    def header_bytes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def latency_s(self) -> float: ...
    @latency_s.setter
    def latency_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def multipath_window_s(self) -> float: ...
    @multipath_window_s.setter
    def multipath_window_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def packet_bytes(self) -> int: ...
    @packet_bytes.setter
    def packet_bytes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def preamble_s(self) -> float: ...
    @preamble_s.setter
    def preamble_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def queue_bytes(self) -> int: ...
    @queue_bytes.setter
    def queue_bytes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def receiver_noise_db_hz(self) -> float: ...
    @receiver_noise_db_hz.setter
    def receiver_noise_db_hz(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def retransmissions(self) -> int: ...
    @retransmissions.setter
    def retransmissions(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def slot_s(self) -> float: ...
    @slot_s.setter
    def slot_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def source_level_db(self) -> float: ...
    @source_level_db.setter
    def source_level_db(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def speed_max_m_s(self) -> float: ...
    @speed_max_m_s.setter
    def speed_max_m_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def symbol_s(self) -> float: ...
    @symbol_s.setter
    def symbol_s(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class LinkFault:
    """
    An interval in which packets are lost with some probability.
    """
    def __init__(
        self,
        from_s: typing.SupportsFloat | typing.SupportsIndex,
        until_s: typing.SupportsFloat | typing.SupportsIndex,
        loss: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    @property
    def from_s(self) -> float: ...
    @property
    def loss(self) -> float: ...
    @property
    def until_s(self) -> float: ...

class LinkSpec:
    """
    Parameters of the link between the station and the vehicles.
    """

    modem: ModemSpec
    def __init__(self) -> None: ...
    def set_bottom(
        self,
        density_ratio: typing.SupportsFloat | typing.SupportsIndex,
        speed_ratio: typing.SupportsFloat | typing.SupportsIndex,
        attenuation_db_wavelength: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    @property
    def faults(self) -> list[LinkFault]: ...
    @faults.setter
    def faults(self, arg0: collections.abc.Sequence[LinkFault]) -> None: ...
    @property
    def shipping(self) -> float: ...
    @shipping.setter
    def shipping(self, arg1: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def station_transducer_world_m(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @station_transducer_world_m.setter
    def station_transducer_world_m(
        self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]
    ) -> None: ...
    @property
    def wind_m_s(self) -> float: ...
    @wind_m_s.setter
    def wind_m_s(self, arg1: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class Reception:
    """
    How a packet reaches a receiver; levels in dB re 1 uPa.
    """
    def packet_loss(self, modem: ModemSpec, bytes: typing.SupportsInt | typing.SupportsIndex) -> float:
        """
        Return the probability that a packet with this many bytes is lost due to noise.
        """
    @property
    def bed_departure(self) -> float:
        """
        departure of the bed between the ends from the assumed flat bottom, as a fraction of its depth; 0 if no
        significant arrival has bounced off the bottom
        """
    @property
    def bed_is_uneven(self) -> bool:
        """
        whether the bed is too uneven for the assumed flat bottom: bed_departure is above 0.05
        """
    @property
    def closing_m_s(self) -> float:
        """
        closing speed of the ends along the strongest arrival
        """
    @property
    def delay_s(self) -> float:
        """
        delay of the first arrival within 20 dB of the strongest
        """
    @property
    def noise_db(self) -> float:
        """
        within the band, including interference between symbols
        """
    @property
    def reached(self) -> bool: ...
    @property
    def signal_db(self) -> float: ...
    @property
    def snr_db(self) -> float: ...
    @property
    def spread_s(self) -> float:
        """
        from the first to the last arrival within 20 dB of the strongest
        """

class LinkDelivery:
    """
    A message that has arrived. from, to: nodes; topic: an index.
    """
    @property
    def arrived_ns(self) -> int: ...
    @property
    def from_node(self) -> int: ...
    @property
    def given_ns(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def payload(self) -> bytes: ...
    @property
    def to_node(self) -> int: ...
    @property
    def topic(self) -> int: ...

class TopicCounts:
    """
    Outcomes of the messages that a node submitted on a topic.
    """
    @property
    def bytes_delivered(self) -> int: ...
    @property
    def bytes_sent(self) -> int: ...
    @property
    def delay_s(self) -> float:
        """
        sum over all delivered messages
        """
    @property
    def delivered(self) -> int: ...
    @property
    def given(self) -> int: ...
    @property
    def late(self) -> int:
        """
        dropped because the deadline passed before they could be sent
        """
    @property
    def lost(self) -> dict[str, int]:
        """
        Lost messages by reason. sending: the receiver was sending at the time; unheard: there is no path.
        """
    @property
    def refused(self) -> int:
        """
        refused because the queue was full
        """
    @property
    def replaced(self) -> int:
        """
        replaced by newer messages before they were sent
        """
    @property
    def resent(self) -> int:
        """
        retransmissions after a missing acknowledgement
        """
    @property
    def sent(self) -> int: ...

class LinkQuality:
    """
    The link quality that a node last observed for another.
    """
    @property
    def closing_m_s(self) -> float: ...
    @property
    def delay_s(self) -> float: ...
    @property
    def heard_ns(self) -> int:
        """
        when the last message arrived; 0 if none has
        """
    @property
    def packets(self) -> int: ...
    @property
    def packets_lost(self) -> int: ...
    @property
    def packets_uneven(self) -> int:
        """
        packets for which the bed was too uneven for the assumed flat bottom (Reception.bed_is_uneven)
        """
    @property
    def snr_db(self) -> float: ...
    @property
    def spread_s(self) -> float: ...

class LinkWater:
    """
    The propagation of sound between transducers.
    """
    def __init__(self, spec: LinkSpec, water: Water) -> None: ...
    def receive(self, scene: RayScene, from_world_m: typing.Any, to_world_m: typing.Any) -> Reception:
        """
        Return how a packet would be received, between two points at rest.
        """

class MemberSpec:
    """
    Everything from which one simulation of a batch is built, apart from terrain and solids.
    """
    def __init__(
        self,
        water: Water,
        simulation: SimulationSpec,
        vehicles: collections.abc.Sequence[VehicleSpec],
        link: LinkSpec | None = None,
        objects: collections.abc.Sequence[ObjectSpec] = [],
        tethers: collections.abc.Sequence[TetherSpec] = [],
    ) -> None:
        """
        vehicles, objects: shared, not copied; they must not be changed afterwards.
        """

class Batch:
    """
    Simulations of one world, advanced and read together. Arrays that receive results are C-ordered, with
    one row per member; results do not depend on the number of threads. Calls release the GIL and raise
    ValueError naming the member, as batch[3].
    """
    def __init__(
        self,
        world: World,
        scene: RayScene,
        members: collections.abc.Sequence[MemberSpec],
        threads: typing.SupportsInt | typing.SupportsIndex,
    ) -> None: ...
    def acoustic_ping(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        ranges_m: numpy.typing.NDArray[numpy.float32],
        points_sonar_m: numpy.typing.NDArray[numpy.float32],
        incidence_rad: numpy.typing.NDArray[numpy.float32],
        intensity_db: numpy.typing.NDArray[numpy.float32],
        labels: numpy.typing.NDArray[numpy.uint16],
        valid: numpy.typing.NDArray[numpy.bool],
        snr_db: numpy.typing.NDArray[numpy.float32],
        travel_time_s: numpy.typing.NDArray[numpy.float32],
        deviation_m: numpy.typing.NDArray[numpy.float32],
        vertical_deviation_m: numpy.typing.NDArray[numpy.float32],
        horizontal_deviation_m: numpy.typing.NDArray[numpy.float32],
        detections: numpy.typing.NDArray[numpy.uint8],
        world_from_sonar: numpy.typing.NDArray[numpy.float64],
    ) -> None:
        """
        Ping in physics mode. Raises ValueError in geometry mode.
        """
    def beams(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> int:
        """
        Return the number of beams of the first member's sonar.
        """
    def in_physics_mode(
        self, vehicle: typing.SupportsInt | typing.SupportsIndex, sonar: typing.SupportsInt | typing.SupportsIndex
    ) -> list[bool]:
        """
        Return, for each member, whether its sonar is in physics mode.
        """
    def member(self, index: typing.SupportsInt | typing.SupportsIndex) -> Simulation:
        """
        Return a member, valid until it is restarted. Must be used only while no call to the batch is running;
        a member cannot be restarted separately.
        """
    def motion(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        times_ns: numpy.typing.NDArray[numpy.uint64],
        positions_world_m: numpy.typing.NDArray[numpy.float64],
        orientations_xyzw: numpy.typing.NDArray[numpy.float64],
        velocities_body: numpy.typing.NDArray[numpy.float64],
        collisions: numpy.typing.NDArray[numpy.uint64],
        released: numpy.typing.NDArray[numpy.bool],
    ) -> None: ...
    def ping(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sonar: typing.SupportsInt | typing.SupportsIndex,
        ranges_m: numpy.typing.NDArray[numpy.float32],
        points_sonar_m: numpy.typing.NDArray[numpy.float32],
        incidence_rad: numpy.typing.NDArray[numpy.float32],
        intensity_db: numpy.typing.NDArray[numpy.float32],
        labels: numpy.typing.NDArray[numpy.uint16],
        valid: numpy.typing.NDArray[numpy.bool],
        world_from_sonar: numpy.typing.NDArray[numpy.float64],
    ) -> None:
        """
        Ping in geometry mode.
        """
    def read_sensor(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        sensor: typing.SupportsInt | typing.SupportsIndex,
        with_noise: bool,
        values: numpy.typing.NDArray[numpy.float64],
        stamps_ns: numpy.typing.NDArray[numpy.uint64],
        valid: numpy.typing.NDArray[numpy.bool],
    ) -> None: ...
    def release(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        members: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
    ) -> None: ...
    def restart(
        self,
        members: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        specs: collections.abc.Sequence[MemberSpec] = [],
    ) -> None:
        """
        Restart members, with new specs if any are given. Raises ValueError without changing anything.
        """
    def set_efforts(self, vehicle: typing.SupportsInt | typing.SupportsIndex, efforts: typing.Any) -> None:
        """
        Set efforts (n, 6), each in [-1, 1]. Raises ValueError without changing anything.
        """
    def set_fins(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        names: collections.abc.Sequence[str],
        angles_rad: typing.Any,
    ) -> None:
        """
        Set fin deflections (n, names) [rad]; the others are centred. Raises ValueError, after the other members
        have been commanded.
        """
    def set_states(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        members: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        states: collections.abc.Sequence[BodyState],
    ) -> None: ...
    def set_thrusters(
        self,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        names: collections.abc.Sequence[str],
        commands: typing.Any,
    ) -> None:
        """
        Set thruster commands (n, names), each in [-1, 1]; the others stop. Raises ValueError, after the other
        members have been commanded.
        """
    def set_wrenches(self, vehicle: typing.SupportsInt | typing.SupportsIndex, wrenches_body: typing.Any) -> None:
        """
        Set wrenches (n, 6) [N, N m]. Raises ValueError.
        """
    def step(self, count: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        """
        Advance all members by fixed steps. Can be interrupted by Ctrl-C.
        """
    def step_each(self, counts: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None:
        """
        Advance each member by its own number of steps, (n,). Can be interrupted by Ctrl-C.
        """

class ServoMotor:
    """
    A motor of an autopilot's frame: the servo output that drives a thruster.
    """
    def __init__(
        self,
        output: typing.SupportsInt | typing.SupportsIndex,
        thruster: str,
        direction: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        output: index, from 0. direction: 1 or -1, the sign of the thruster's command at a pulse above 1500 us.
        """
    @property
    def direction(self) -> float: ...
    @property
    def output(self) -> int: ...
    @property
    def thruster(self) -> str: ...

class ServoCounts:
    """
    Counts of the packets that a ServoExchange has received since it began.
    """
    @property
    def cut(self) -> int:
        """
        Servo packets of a wrong length.
        """
    @property
    def foreign(self) -> int:
        """
        Packets that are not servo packets.
        """
    @property
    def frames(self) -> int:
        """
        Frames that made a step.
        """
    @property
    def lost(self) -> int:
        """
        Frames missing between two that arrived.
        """
    @property
    def others(self) -> int:
        """
        Frames of another autopilot, which are ignored.
        """
    @property
    def repeated(self) -> int:
        """
        Frames that arrived again, without a step.
        """
    @property
    def resets(self) -> int:
        """
        Autopilots that started again.
        """

class ServoExchange:
    """
    The physics side of ArduPilot's JSON interface: UDP, one frame of the autopilot for each step.
    """
    def __init__(
        self,
        simulation: Simulation,
        vehicle: typing.SupportsInt | typing.SupportsIndex,
        motors: collections.abc.Sequence[ServoMotor],
        imu: typing.SupportsInt | typing.SupportsIndex,
        altimeter: typing.SupportsInt | typing.SupportsIndex | None,
        with_noise: bool,
        watched: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        host: str,
        port: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        imu, altimeter: indices of sensors, which are read with their errors if with_noise. watched: outputs
        whose change ends a run. port: 0 for any free port. Raises ValueError, or OSError if the port is not
        available.
        """
    def wait(self, patience_s: typing.SupportsFloat | typing.SupportsIndex) -> bool:
        """
        Wait until a packet has arrived, and return whether one has. From then until the next step, an autopilot
        in lockstep is waiting, too, so data that other sockets deliver to it do not depend on the wall clock.
        """
    @property
    def counts(self) -> ServoCounts: ...
    @property
    def has_frame(self) -> bool:
        """
        True if a frame is in, which waits for those of other exchanges.
        """
    @property
    def peer(self) -> str:
        """
        The autopilot's address and port; empty before its first frame.
        """
    @property
    def port(self) -> int: ...
    @property
    def rate_hz(self) -> int:
        """
        The rate that the last frame announced.
        """

def absorption_db_km(
    frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
    temperature_deg_c: typing.SupportsFloat | typing.SupportsIndex,
    salinity_psu: typing.SupportsFloat | typing.SupportsIndex,
    depth_m: typing.SupportsFloat | typing.SupportsIndex,
    acidity_ph: typing.SupportsFloat | typing.SupportsIndex = 8.0,
) -> float:
    """
    Return the absorption of sound in water [dB/km] by Francois and Garrison 1982. Raises ValueError.
    """

def added_mass(
    vertices_m: typing.Any,
    triangles: typing.Any,
    density_kg_m3: typing.SupportsFloat | typing.SupportsIndex,
    panels: typing.SupportsInt | typing.SupportsIndex,
) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[6, 6]"]:
    """
    Return the added mass (6, 6) of a closed hull about its origin [kg, kg m, kg m^2] in ideal flow, far from surface
    and bed, by a boundary-element method (Steinbach 2008, sec. 6.6). vertices_m: (n, 3). triangles: (m, 3), winding
    outward. panels: triangles are split until there are so many, at most 10000. The result is a lower bound, apart
    from quadrature. Uses all threads. Raises ValueError.
    """

def ambient_noise_db_hz(
    frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
    wind_m_s: typing.SupportsFloat | typing.SupportsIndex,
    shipping: typing.SupportsFloat | typing.SupportsIndex,
) -> float: ...
def arrivals(
    profile: SoundSpeedProfile,
    from_depth_m: typing.SupportsFloat | typing.SupportsIndex,
    to_depth_m: typing.SupportsFloat | typing.SupportsIndex,
    across_m: typing.SupportsFloat | typing.SupportsIndex,
    bottom_m: typing.SupportsFloat | typing.SupportsIndex,
    frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
    bottom: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"],
    surface_rms_m: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    absorption_db_km: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    within_db: typing.SupportsFloat | typing.SupportsIndex = 40.0,
    most: typing.SupportsInt | typing.SupportsIndex = 500,
    most_bounces: typing.SupportsInt | typing.SupportsIndex = 1000,
) -> list[Arrival]:
    """
    Return all arrivals between two points, sorted by time. bottom: its density and speed of sound relative to
    the water, and its attenuation [dB per wavelength]. Raises ValueError. Releases the GIL.
    """

def bit_error(modulation: Modulation, fading: bool, gamma: typing.SupportsFloat | typing.SupportsIndex) -> float: ...
def bottom_echo(
    sonar: SonarParameters,
    bottom: BottomMaterial,
    range_m: typing.SupportsFloat | typing.SupportsIndex,
    incidence_rad: typing.SupportsFloat | typing.SupportsIndex,
    steering_rad: typing.SupportsFloat | typing.SupportsIndex,
    sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
    absorption_db_m: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[float, float, float]:
    """
    Return, for the echo of a plane bottom, its signal-to-noise ratio [dB] by the active sonar equation,
    the number of looks that the detector averages, and the ratio [dB] at which half of such echoes are
    detected.
    """

def bottom_loss_db(
    density_ratio: typing.SupportsFloat | typing.SupportsIndex,
    speed_ratio: typing.SupportsFloat | typing.SupportsIndex,
    attenuation_db_wavelength: typing.SupportsFloat | typing.SupportsIndex,
    grazing_rad: typing.SupportsFloat | typing.SupportsIndex,
) -> float: ...
def decode_depth_string(
    text: str,
    beams: typing.SupportsInt | typing.SupportsIndex,
    range_limit_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the ranges of a depthArray text, (beams,) float32; values greater than range_limit_m become
    inf. Raises ValueError naming the beam unless the text consists of exactly `beams` plain decimals,
    each followed by a.
    """

def depth_image(
    camera: DepthCamera,
    scene: RayScene,
    position_m: typing.Any,
    orientation_xyzw: typing.Any,
    threads: typing.SupportsInt | typing.SupportsIndex = 1,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return a depth image, (height, width) float32 along the camera's x axis, inf if nothing is hit. Raises
    ValueError. Releases the GIL.
    """

def depth_image_ranges(
    camera: DepthCamera, depth_m: typing.Any, angles_rad: typing.Any, reduction: RowReduction, interpolate: bool
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the ranges (n,) float32, inf for no echo, from depth_m (height, width) and angles_rad (n,).
    Raises ValueError.
    """

def effect_names() -> list[str]:
    """
    Return the names of the effects.
    """

def encode_depth_string(ranges_m: typing.Any, range_max_m: typing.SupportsFloat | typing.SupportsIndex) -> str:
    """
    Return the published depthArray text: each range in C#'s G7 format, followed by the letter a.
    ranges_m: (n,) float32, in [0, range_max_m], or inf for no echo, which is written as range_max_m.
    Raises ValueError naming the beam for any other value.
    """

def filter_range(
    points_m: typing.Any,
    min_m: typing.SupportsFloat | typing.SupportsIndex,
    max_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the points whose distance to the origin is in [min_m, max_m], (n, 3) float32. Raises
    ValueError. Releases the GIL.
    """

def ground_plane(
    points_m: typing.Any,
    distance_m: typing.SupportsFloat | typing.SupportsIndex,
    max_slope_rad: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"], float, numpy.ndarray]:
    """
    Fit a ground plane by pcl::RandomSampleConsensus. points_m: (n, 3) float32, finite. Returns the upward
    normal (3,), the offset [m] with normal . p + offset = 0, and the inliers (n,) bool. Raises
    ValueError. Releases the GIL.
    """

def highest_in_corridor(
    points_m: typing.Any,
    world_from_points: typing.Any,
    position_world_m: typing.Any,
    heading_rad: typing.SupportsFloat | typing.SupportsIndex,
    half_width_m: typing.SupportsFloat | typing.SupportsIndex,
    ahead_m: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[float, float, float] | None:
    """
    Return x, y, z in the world of the highest point in the corridor from half_width_m behind a position
    to ahead_m in front of it, half_width_m to either side of the heading; None if there is none.
    points_m: (n, 3); points with NaN are ignored. world_from_points: (4, 4). position_world_m: (3,).
    Raises ValueError.
    """

def imaging_kind(name: str) -> ImagingKind:
    """
    Return the kind with this name. Raises ValueError listing the known names.
    """

def imaging_kinds() -> list[str]:
    """
    Return the built-in kinds of imaging sonar.
    """

def instruction_set() -> str:
    """
    Return the instruction set that kernels use: avx512, avx2 or portable. It is the widest that this
    processor supports, or the one that UWSIM_INSTRUCTION_SET selects. Raises ValueError if that is not an
    instruction set, or the processor does not support it.
    """

def jerlov_types() -> list[str]:
    """
    Return the names of the Jerlov water types.
    """

def material_names() -> list[str]:
    """
    Return the names of the materials.
    """

def mounted_pose(
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
    Return the pose of an object mounted on a carrier: position (3,), orientation (4,) as x, y, z, w, and
    both as (4, 4).
    """

def mounted_poses(
    positions_m: typing.Any,
    orientations_xyzw: typing.Any,
    mount_positions_m: typing.Any,
    mount_orientations_xyzw: typing.Any,
) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Return n poses as mounted_pose does: positions (n, 3) and orientations (n, 4) as x, y, z, w.
    """

def multibeam_model(number: typing.SupportsInt | typing.SupportsIndex) -> MultibeamModel:
    """
    Return the EM 2040 MKII variant 1..4. Raises ValueError for other numbers.
    """

def packet_error(
    bit_error: typing.SupportsFloat | typing.SupportsIndex, bits: typing.SupportsFloat | typing.SupportsIndex
) -> float: ...
def pass_through(
    points_m: typing.Any,
    axis: typing.SupportsInt | typing.SupportsIndex,
    min_m: typing.SupportsFloat | typing.SupportsIndex,
    max_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the points whose coordinate along axis 0, 1 or 2 is in [min_m, max_m], by pcl::PassThrough; (n,
    3) float32. Discards non-finite points. Raises ValueError. Releases the GIL.
    """

def play_servo_frames(
    simulation: Simulation,
    vehicles: collections.abc.Sequence[
        tuple[typing.SupportsInt | typing.SupportsIndex, collections.abc.Sequence[ServoMotor]]
    ],
    frames: collections.abc.Sequence[bytes],
    steers: collections.abc.Sequence[bool],
) -> None:
    """
    Make one step for each frame, as run_servo_exchanges does. vehicles: index and motors of each. frames: bytes
    for each vehicle, 32 uint16 [us] per step. Releases the GIL. Raises ValueError.
    """

def points_above(
    points_m: typing.Any, world_from_points: typing.Any, z_world_m: typing.SupportsFloat | typing.SupportsIndex
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Return the points that are higher than z_world_m, (k, 3) float64, world frame, in their original
    order. points_m: (n, 3); points with NaN are ignored. world_from_points: (4, 4). Raises ValueError.
    """

def refracted(
    direction: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
    normal: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
    n_from: typing.SupportsFloat | typing.SupportsIndex,
    n_to: typing.SupportsFloat | typing.SupportsIndex,
) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"] | None:
    """
    Return the direction refracted by Snell's law, (3,), or None for total reflection. normal: (3,),
    towards the side that the ray comes from.
    """

def relative_transform(
    world_from_target: typing.Any, world_from_source: typing.Any
) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 4]"]:
    """
    Return target_from_source, (4, 4) float64, from rigid transforms. Raises ValueError.
    """

def remove_box(
    points_m: typing.Any, box_min_m: typing.Any, box_max_m: typing.Any
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the points outside a box, whose faces count as inside, by a negative pcl::CropBox; (n, 3)
    float32. box_*_m: (3,) float64. Discards non-finite points. Raises ValueError. Releases the GIL.
    """

def remove_outliers(
    points_m: typing.Any,
    neighbours: typing.SupportsInt | typing.SupportsIndex,
    deviations: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Remove outliers by pcl::StatisticalOutlierRemoval; (n, 3) float32. Discards non-finite points. Raises
    ValueError. Releases the GIL.
    """

def remove_unfinished_files() -> None:
    """
    Remove the temporary files of all maps being written, for a process that ends while other threads are
    writing.
    """

def render_many(
    scenes: collections.abc.Sequence[CameraScene | None],
    cameras: collections.abc.Sequence[Camera],
    optics: collections.abc.Sequence[Optics],
    positions_m: typing.Any,
    orientations_xyzw: typing.Any,
    times_ns: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
    effects: collections.abc.Sequence[str],
    lamps: collections.abc.Sequence[
        collections.abc.Sequence[tuple[typing.SupportsInt | typing.SupportsIndex, SpotLamp]]
    ],
    vehicle_positions_m: typing.Any,
    vehicle_orientations_xyzw: typing.Any,
    hidden_vehicle: typing.SupportsInt | typing.SupportsIndex | None,
    velocities_camera: typing.Any,
    threads: typing.SupportsInt | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Render one picture of each of n scenes, (n, H, W, 3) uint8, like CameraScene.render, several at a time.
    scenes: None for a black picture. cameras: all with pictures of the same size. positions_m (n, 3),
    orientations_xyzw (n, 4) and velocities_camera (n, 6) of the cameras. lamps: for each scene, the lamps
    that are on, as (vehicle, lamp with its pose on that vehicle). vehicle_positions_m (n, v, 3),
    vehicle_orientations_xyzw (n, v, 4): of all vehicles. Releases the GIL. Raises ValueError.
    """

def run_servo_exchanges(
    exchanges: collections.abc.Sequence[ServoExchange],
    simulation: Simulation,
    steps: typing.SupportsInt | typing.SupportsIndex,
    patience_s: typing.SupportsFloat | typing.SupportsIndex,
    steers: collections.abc.Sequence[bool],
) -> tuple[list[bytes], bool]:
    """
    Make one step when a frame of each exchange is in, at most `steps`. Return each exchange's outputs as bytes,
    32 uint16 [us] per step, and whether a watched output changed, which ends the call. The call also ends if a
    frame is missing for patience_s; those that are in remain. steers: for each exchange, whether its frames
    command the thrusters. Releases the GIL. Raises ValueError.
    """

def saved_build(state: bytes) -> str:
    """
    Return the fingerprint of the build that saved a state. Raises ValueError for a damaged state.
    """

def saved_notes(state: bytes, scenario: str, build: str) -> str:
    """
    Return the notes in a saved state. Raises ValueError for a damaged state or another scenario.
    """

def scan_to_points(
    ranges_m: typing.Any,
    angle_min_rad: typing.SupportsFloat | typing.SupportsIndex,
    angle_increment_rad: typing.SupportsFloat | typing.SupportsIndex,
    range_min_m: typing.SupportsFloat | typing.SupportsIndex,
    range_max_m: typing.SupportsFloat | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the points of a LaserScan in its own frame (x forward, y left), (n, 3) float32, in beam order.
    As in laser_geometry, only ranges with range_min <= range < range_max are used. ranges_m: (beams,)
    float32. Raises ValueError. Releases the GIL.
    """

def scan_to_world(
    ranges_m: typing.Any,
    angle_min_rad: typing.SupportsFloat | typing.SupportsIndex,
    angle_increment_rad: typing.SupportsFloat | typing.SupportsIndex,
    range_min_m: typing.SupportsFloat | typing.SupportsIndex,
    range_max_m: typing.SupportsFloat | typing.SupportsIndex,
    box_min_m: typing.Any,
    box_max_m: typing.Any,
    world_from_body: typing.Any,
    world_from_sonar: typing.Any,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the points of a LaserScan in the world without those inside a box in the body's frame, (n, 3)
    float32: scan_to_points, filter_range, transform_points, remove_box and transform_points in one call.
    ranges_m: (beams,) float32. box_*_m: (3,). world_from_*: (4, 4), rigid. Raises ValueError. Releases
    the GIL.
    """

def sea_water_density_kg_m3(
    temperature_deg_c: typing.SupportsFloat | typing.SupportsIndex,
    salinity_psu: typing.SupportsFloat | typing.SupportsIndex,
    gauge_pressure_pa: typing.SupportsFloat | typing.SupportsIndex = 0.0,
) -> float:
    """
    Return the density by EOS-80 (UNESCO 44, 1983); gauge_pressure_pa: pressure above atmospheric. Raises
    ValueError.
    """

def seabed_backscatter_db(
    seabed: str,
    grazing_rad: typing.Any,
    frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
    sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex = 1500.0,
) -> numpy.ndarray:
    """
    Return the backscattering strength [dB per square metre] of a seabed at grazing angles (n,), (n,) float64, by
    APL-UW TR 9407, ch. IV. Raises ValueError for an unknown seabed, or outside of 10 to 100 kHz, 1400 to 1600 m/s
    and [0, pi/2].
    """

def seabeds() -> dict[str, tuple[float, float, float]]:
    """
    Return the seabeds of APL-UW TR 9407, table 2, by name: density and speed of sound relative to water, and the
    attenuation [dB per wavelength].
    """

def sensor_kind(name: str) -> SensorKind:
    """
    Return the kind with this name. Raises ValueError listing the known names.
    """

def sensor_kinds() -> list[str]:
    """
    Return the built-in kinds of sensor.
    """

def solid_properties(vertices_m: typing.Any, triangles: typing.Any) -> SolidProperties:
    """
    Return volume, centroid and inertia of a closed mesh (n, 3), (m, 3). Raises ValueError if the mesh is
    open or inverted.
    """

def sound_speed_m_s(
    temperature_deg_c: typing.SupportsFloat | typing.SupportsIndex,
    salinity_psu: typing.SupportsFloat | typing.SupportsIndex,
    depth_m: typing.SupportsFloat | typing.SupportsIndex,
    equation: str = "automatic",
) -> float:
    """
    Return the speed of sound in water [m/s] by unesco (Chen and Millero 1977), del_grosso (1974; both
    with Wong and Zhu's coefficients of 1995), belogolskii (1999, fresh water), leroy (2008), mackenzie
    (1981), medwin (1975), or the equation whose range of validity fits best. Raises ValueError.
    """

def sound_speed_profile(water: Water) -> SoundSpeedProfile:
    """
    Return the speed of sound by depth: that of the water's profile if it specifies one, else by its equation.
    """

def soundings(
    directions_world: typing.Any, travel_time_s: typing.Any, origin_world_m: typing.Any, profile: SoundSpeedProfile
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Return soundings as a survey computes them, (n, 3) float64, world frame: rays are traced from the
    transmitted directions_world (n, 3) for half of the two-way travel_time_s (n,), through `profile`,
    which may differ from the true one. The result is NaN for a time that is not finite. Raises
    ValueError. Releases the GIL.
    """

def stream_name(owner: str, part: str) -> str:
    """
    Return the name of the random stream of a vehicle's sensor, sonar or camera.
    """

def surface_class_names() -> list[str]:
    """
    Return the names of the surface classes, indexed by the numbers in Picture.classes.
    """

def surface_loss_db(
    frequency_hz: typing.SupportsFloat | typing.SupportsIndex,
    sound_speed_m_s: typing.SupportsFloat | typing.SupportsIndex,
    rms_height_m: typing.SupportsFloat | typing.SupportsIndex,
    grazing_rad: typing.SupportsFloat | typing.SupportsIndex,
) -> float: ...
def transform_points(
    points_source_m: typing.Any, target_from_source: typing.Any
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Transform points by pcl::transformPointCloud. points_source_m: (n, 3) float32. target_from_source: (4,
    4) float64, rigid. Returns (n, 3) float32. Raises ValueError. Releases the GIL.
    """

def voxel_grid(
    points_m: typing.Any, voxel_m: typing.SupportsFloat | typing.SupportsIndex
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Return the centroid of the points in each cube with edge voxel_m, by pcl::VoxelGrid. points_m: (n, 3)
    float32. Returns (k, 3) float32. Discards non-finite points. Raises ValueError. Releases the GIL.
    """

def water_targets_at(
    group: WaterTargets,
    seed: typing.SupportsInt | typing.SupportsIndex,
    time_s: typing.SupportsFloat | typing.SupportsIndex,
) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 3]"]:
    """
    Return the positions of a group's targets, (count, 3) float64, world frame.
    """

RANGING_PING_BYTES: int = 2
