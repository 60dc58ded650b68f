"""Sonars that make pictures: forward-looking, side-scan, and a profiling single beam.

They hear the same scene and water as everything else. A picture is a function of the place, the scenario's seed and a
number (by default simulated time): the same again whenever asked for again, whatever the number of threads. `sim` is a
Simulator or anything with its scene, world, seed, threads and time_ns.

A pose is a matrix (4, 4), world from sonar, the sonar's x axis ahead, y to port, z up. Of a sonar on a vehicle it is
`rov.pose.world_from_body @ imaging.pose_matrix(mount_m, pitch_rad=0.3)`. A head above the water or within the ground
or a solid hears only noise.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from dataclasses import field as dataclass_field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from uwsim import _core

Matrix = NDArray[np.float64]
Levels = NDArray[np.float32]

POSE_TOLERANCE = 1e-6  # by which a pose's rotation may miss being one


class Place(Protocol):
    """What a sonar needs of a simulator."""

    @property
    def scene(self) -> _core.RayScene:
        """The surfaces that echo."""

    @property
    def world(self) -> _core.World:
        """Its water is heard through."""

    @property
    def seed(self) -> int:
        """Of the speckle."""

    @property
    def threads(self) -> int:
        """How many may be used; what is heard does not depend on it."""

    @property
    def time_ns(self) -> int:
        """Simulated time."""


@dataclass(frozen=True, kw_only=True)
class Acoustics:
    """What the three hear with. Levels in dB re 1 uPa.

    source_level_db: at 1 m. noise_level_db: in the receiver's band behind its beam former. bottom_strength_db,
    solid_strength_db: Lambert's, per square metre at normal incidence, of terrain and of solids; strengths_db: of
    single ones, by World.label_names. range_max_m is cut
    into range_bins, each a resolution cell. The gain is gain_db_decade log10 R + 2 alpha R, alpha that of the water at
    the head (Francois and Garrison); time_varied_gain False leaves levels as received. looks: independent looks that a
    cell averages; 1 is full speckle (Rayleigh amplitude), 0 none.
    """

    frequency_hz: float
    source_level_db: float
    noise_level_db: float
    range_max_m: float
    range_bins: int
    bottom_strength_db: float = -30.0  # rock on the EM 2040's data sheet, as the multibeam's geometry mode has it
    solid_strength_db: float = -15.0  # assumed: steel and concrete, harder and rougher than the bed
    strengths_db: Mapping[str, float] = dataclass_field(default_factory=dict)
    time_varied_gain: bool = True
    # 30 for spreading over a cell that grows with range, 20 for Lambert's law, by which a level bottom's strength falls
    # as (height / range)^2: together a flat bottom comes out even.
    gain_db_decade: float = 50.0
    looks: int = 1

    @property
    def bin_m(self) -> float:
        """Width of a range bin."""
        return self.range_max_m / self.range_bins

    @property
    def bin_centres_m(self) -> NDArray[np.float64]:
        """(bins,) float64."""
        return np.asarray((np.arange(self.range_bins) + 0.5) * self.bin_m, np.float64)


@dataclass(frozen=True, kw_only=True)
class ForwardLooking(Acoustics):
    """A forward-looking imaging sonar. Its defaults are of the class of the Oculus M750d in its low-frequency mode.

    [OM] Blueprint Subsea, Oculus M-series user manual: 130 deg across, 20 deg upright; [VR] VideoRay's training page on
    that sonar: 512 beams. What names neither is assumed.
    """

    frequency_hz: float = 750e3  # by the name
    source_level_db: float = 205.0
    # Thermal noise -15 + 20 log10 f[kHz] (Mellen 1952) + 10 log10 of 19 kHz, less an assumed directivity of 30 dB.
    noise_level_db: float = 55.0
    range_max_m: float = 40.0
    range_bins: int = 1000
    beams: int = 512  # [VR]
    field_of_view_rad: float = float(np.radians(130.0))  # [OM]
    beam_width_rad: float = float(np.radians(1.0))
    vertical_width_rad: float = float(np.radians(20.0))  # [OM], taken as two-way
    taper: float = 0.25  # shading of the receiving array: side lobes at about -22 dB
    columns_per_beam: int = 2
    rays_per_column: int = 384


@dataclass(frozen=True, kw_only=True)
class SideScan(Acoustics):
    """A side-scan sonar. Its defaults are of the class of the StarFish 450.

    [SF] starfishsonar.com, "What is a side scan sonar": beams 30 deg below the level, most energy within 60 deg. The
    page's width along the track is 2 deg; the default is that of a longer array. What names no source is assumed.

    planes: of rays across the track, over the beam's width. detection_db: over the noise, where the bottom begins.
    """

    frequency_hz: float = 450e3  # by the name
    source_level_db: float = 210.0
    noise_level_db: float = 50.0  # as ForwardLooking's, of 15 kHz
    range_max_m: float = 50.0
    range_bins: int = 1000
    along_width_rad: float = float(np.radians(0.5))
    vertical_width_rad: float = float(np.radians(60.0))  # [SF], taken as two-way
    depression_rad: float = float(np.radians(30.0))  # [SF]
    planes: int = 3
    detection_db: float = 12.0


@dataclass(frozen=True, kw_only=True)
class SingleBeam(Acoustics):
    """A profiling sonar with one pencil beam. Its defaults are of the class of the Imagenex 881L.

    [IM] Imagenex, data sheet 445-039: 675 kHz, 1.8 deg, 10 mm. Round here, while that one's beam is a fan of 1.8 x 20
    deg. What names no source is assumed. detection_db: over the noise; an echo's peak below it is no echo.
    """

    frequency_hz: float = 675e3  # [IM]
    source_level_db: float = 205.0
    noise_level_db: float = 55.0  # as ForwardLooking's, of 75 kHz and a directivity of 35 dB
    range_max_m: float = 20.0
    range_bins: int = 2000  # [IM]
    gain_db_decade: float = 20.0  # a round beam's patch on the bottom grows with the square of range
    beam_width_rad: float = float(np.radians(1.8))  # [IM]
    rays_across: int = 17
    detection_db: float = 15.0


KINDS: dict[str, type[Acoustics]] = {
    "forward_looking": ForwardLooking, "side_scan": SideScan, "single_beam": SingleBeam
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class SonarImage:
    """What a forward-looking sonar sees.

    level_db: (bins, beams) float32, dB re 1 uPa, finite. noise_db: (bins,) float32, what noise alone shows on average.
    ranges_m (bins,), bearings_rad (beams,) float64: the cells' middles, bearings about the sonar's z axis, rising from
    starboard to port. world_from_sonar (4, 4).
    """

    level_db: Levels
    noise_db: Levels
    ranges_m: NDArray[np.float64]
    bearings_rad: NDArray[np.float64]
    world_from_sonar: Matrix
    model: ForwardLooking


@dataclass(frozen=True, eq=False)
class Waterfall:
    """What a side-scan sonar hears along a track, a ping a row.

    port_db, starboard_db: (pings, bins) float32 over slant range, dB re 1 uPa. noise_db: (bins,) float32, what noise
    alone shows on average, in the water of the first ping. ranges_m (bins,) float64. altitude_m (pings,) float32: range
    of the first bottom return, inf where there is none. world_from_sonar (pings, 4, 4).
    """

    port_db: Levels
    starboard_db: Levels
    noise_db: Levels
    ranges_m: NDArray[np.float64]
    altitude_m: NDArray[np.float32]
    world_from_sonar: Matrix
    model: SideScan

    def picture_db(self) -> Levels:
        """(pings, 2 bins) float32: port to the left, its range growing to the left, starboard to the right."""
        return np.concatenate([self.port_db[:, ::-1], self.starboard_db], axis=1)

    def over_ground(self) -> Waterfall:
        """The same by range over ground: r -> sqrt(r^2 - altitude^2), for a bottom that is level at the altitude.

        The water column goes; pings without altitude, and cells beyond the greatest range, are NaN.
        """
        slant_m = np.hypot(self.ranges_m[None, :], self.altitude_m[:, None].astype(np.float64))
        columns = np.floor(np.minimum(slant_m, 1e9) / self.model.bin_m).astype(np.int64)
        inside = columns < self.model.range_bins
        picked = np.where(inside, columns, 0)
        sides = [
            np.where(inside, np.take_along_axis(side, picked, axis=1), np.float32(np.nan))
            for side in (self.port_db, self.starboard_db)
        ]
        return replace(self, port_db=sides[0], starboard_db=sides[1])


@dataclass(frozen=True, eq=False)
class Profiles:
    """What a single beam hears at each of its angles.

    level_db: (angles, bins) float32, dB re 1 uPa. noise_db: (bins,) float32, what noise alone shows on average.
    ranges_m: (angles,) float32, inf = no echo. angles_rad (angles,) float64 about the sonar's z axis, positive to port.
    bin_centres_m (bins,) float64. world_from_sonar (4, 4).
    """

    level_db: Levels
    noise_db: Levels
    ranges_m: NDArray[np.float32]
    angles_rad: NDArray[np.float64]
    bin_centres_m: NDArray[np.float64]
    world_from_sonar: Matrix
    model: SingleBeam

    @property
    def points_world_m(self) -> NDArray[np.float64]:
        """(angles, 3) float64: where the bottom was found on the beam's axis; NaN where there was no echo."""
        ranges = np.where(np.isfinite(self.ranges_m), self.ranges_m, np.nan).astype(np.float64)
        flat = np.stack([np.cos(self.angles_rad), np.sin(self.angles_rad), np.zeros(len(ranges))], axis=1)
        return np.asarray((flat * ranges[:, None]) @ self.world_from_sonar[:3, :3].T + self.world_from_sonar[:3, 3])


def look_ahead(
    sim: Place, world_from_sonar: ArrayLike, model: ForwardLooking | None = None, *, name: str = "forward_looking",
    number: int | None = None,
) -> SonarImage:  # fmt: skip
    """One picture of a forward-looking sonar. Raises ValueError.

    name: of its noise. number: of the look; simulated time in nanoseconds by default.
    """
    model = model or ForwardLooking()
    pose = checked_pose(world_from_sonar)
    core = _core_model(sim, model, _core.ForwardLookingModel())
    level_db = _core.forward_look(
        core, sim.scene, sim.world.water, *_split(pose), sim.seed, name, _number(sim, number), sim.threads
    )
    half = model.field_of_view_rad / 2
    bearings = np.linspace(-half, half, model.beams) if model.beams > 1 else np.array([-half])
    noise_db = _noise_db(model, core, sim, float(pose[2, 3]))
    return SonarImage(level_db, noise_db, model.bin_centres_m, bearings, pose, model)


def look_aside(
    sim: Place, worlds_from_sonar: Sequence[ArrayLike] | Matrix, model: SideScan | None = None, *,
    name: str = "side_scan", first_ping: int = 0,
) -> Waterfall:  # fmt: skip
    """Ping from each pose (pings, 4, 4), x along the track. Raises ValueError.

    Ping k has the number first_ping + k, so that a track may be heard in one call or in many, with the same result.
    """
    model = model or SideScan()
    poses = np.array([checked_pose(pose, f"worlds_from_sonar[{k}]") for k, pose in enumerate(worlds_from_sonar)])
    poses = poses.reshape(-1, 4, 4)
    core = _core_model(sim, model, _core.SideScanModel())
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat() if len(poses) else np.zeros((0, 4))
    port, starboard, altitude = _core.side_scan(
        core, sim.scene, sim.world.water, np.ascontiguousarray(poses[:, :3, 3]), turns, sim.seed, name,
        _whole(first_ping, "first_ping"), sim.threads,
    )  # fmt: skip
    noise_db = _noise_db(model, core, sim, float(poses[0, 2, 3]) if len(poses) else 0.0)
    return Waterfall(port, starboard, noise_db, model.bin_centres_m, altitude, poses, model)


def profile(
    sim: Place, world_from_sonar: ArrayLike, angles_rad: ArrayLike, model: SingleBeam | None = None, *,
    name: str = "single_beam", first_ping: int = 0,
) -> Profiles:  # fmt: skip
    """Ping at each angle (n,) about the sonar's z axis, from its x axis, positive to port. Raises ValueError."""
    model = model or SingleBeam()
    pose = checked_pose(world_from_sonar)
    angles = np.atleast_1d(np.asarray(angles_rad, np.float64))
    core = _core_model(sim, model, _core.SingleBeamModel())
    level_db, ranges_m = _core.single_beam(
        core, sim.scene, sim.world.water, *_split(pose), angles, sim.seed, name, _whole(first_ping, "first_ping"),
        sim.threads,
    )  # fmt: skip
    noise_db = _noise_db(model, core, sim, float(pose[2, 3]))
    return Profiles(level_db, noise_db, ranges_m, angles, model.bin_centres_m, pose, model)


def pose_matrix(
    position_m: Iterable[float] = (0.0, 0.0, 0.0),
    *,
    yaw_rad: float = 0.0,
    pitch_rad: float = 0.0,
    roll_rad: float = 0.0,
) -> Matrix:
    """(4, 4) from a position and turns about z, then the new y (positive: nose down), then the new x. ValueError."""
    matrix = np.eye(4)
    turns = np.array([yaw_rad, pitch_rad, roll_rad], np.float64)
    if not np.isfinite(turns).all():
        raise ValueError(f"yaw, pitch, roll = {turns} rad: must be finite")
    matrix[:3, :3] = Rotation.from_euler("ZYX", turns).as_matrix()
    matrix[:3, 3] = np.asarray(list(position_m), np.float64)
    return checked_pose(matrix)


def checked_pose(pose: ArrayLike, name: str = "world_from_sonar") -> Matrix:
    """The same as (4, 4) float64. Raises ValueError unless it is finite, a rotation and a position."""
    matrix = np.asarray(pose, np.float64)
    if matrix.shape != (4, 4):
        raise ValueError(f"{name}.shape = {matrix.shape}: expected (4, 4)")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name}: must be finite")
    turn = matrix[:3, :3]
    off = max(float(np.abs(turn @ turn.T - np.eye(3)).max()), float(np.abs(matrix[3] - (0, 0, 0, 1)).max()))
    if off > POSE_TOLERANCE or np.linalg.det(turn) < 0:
        raise ValueError(f"{name}: must be a rotation and a position, with 0, 0, 0, 1 below")
    return matrix


def _split(pose: Matrix) -> tuple[Matrix, Matrix]:
    return np.ascontiguousarray(pose[:3, 3]), Rotation.from_matrix(pose[:3, :3]).as_quat()


def _number(sim: Place, number: int | None) -> int:
    return sim.time_ns if number is None else _whole(number, "number")


def _whole(value: int, name: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= value < 2**63:
        raise ValueError(f"{name} = {value!r}: must be a whole number, not negative")
    return int(value)


def _noise_db(model: Acoustics, core: Any, sim: Place, head_z_m: float) -> Levels:
    """Level of mean noise power with each range's gain (bins,)."""
    gain_db = np.zeros(model.range_bins)
    if model.time_varied_gain:
        absorption_db_m = core.acoustics.absorption_db_m(sim.world.water, head_z_m)
        gain_db = model.gain_db_decade * np.log10(model.bin_centres_m) + 2.0 * absorption_db_m * model.bin_centres_m
    return (model.noise_level_db + gain_db).astype(np.float32)


def check(model: Acoustics, sim: Place | None = None) -> None:
    """Raise ValueError, naming the field, for a model that is none; with a sim, strengths_db of what is not there too."""
    _core_model(sim, model, _CORE_MODELS[type(model)]())


_CORE_MODELS: dict[type[Acoustics], Any] = {
    ForwardLooking: _core.ForwardLookingModel, SideScan: _core.SideScanModel, SingleBeam: _core.SingleBeamModel
}  # fmt: skip


def _core_model(sim: Place | None, model: Acoustics, core: Any) -> Any:
    """Fill the native model: each field goes by its name, to the acoustics or to the rest. Raises ValueError."""
    acoustics = _core.ImagingAcoustics()
    for entry in fields(model):
        name, value = entry.name, getattr(model, entry.name)
        if name == "strengths_db":
            if not isinstance(value, Mapping):
                raise ValueError(f"sonar.strengths_db = {value!r}: must be dB by name")
            if sim is not None:
                acoustics.strengths_db = _strengths_by_label(sim.world.label_names, value)
            continue
        target = acoustics if hasattr(acoustics, name) else core
        try:
            setattr(target, name, value)
        except TypeError as error:
            kind = type(getattr(target, name)).__name__
            raise ValueError(f"sonar.{name} = {value!r}: must be of type {kind}") from error
    core.acoustics = acoustics
    core.check()
    return core


def _strengths_by_label(names: Sequence[str], given_db: Mapping[str, float]) -> list[float]:
    unknown = sorted(set(given_db) - set(names[1:]))
    if unknown:
        raise ValueError(f"sonar.strengths_db['{unknown[0]}']: not in the world; there are: {', '.join(names[1:])}")
    for name, value in given_db.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or np.isnan(value):
            raise ValueError(f"sonar.strengths_db['{name}'] = {value!r} dB: must be a number")
    return [float(given_db.get(name, np.nan)) for name in names] if given_db else []
