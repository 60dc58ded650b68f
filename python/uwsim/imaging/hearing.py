"""Looking ahead, looking aside, profiling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.imaging.models import Acoustics, ForwardLooking, SideScan, SingleBeam
from uwsim.imaging.native import Place, core_model
from uwsim.imaging.poses import Matrix, checked_pose, split_pose
from uwsim.imaging.results import Levels, Profiles, SonarImage, Waterfall


def look_ahead(
    sim: Place, world_from_sonar: ArrayLike, model: ForwardLooking | None = None, *, name: str = "forward_looking",
    number: int | None = None,
) -> SonarImage:  # fmt: skip
    """One picture of a forward-looking sonar. Raises ValueError.

    name: of its noise. number: of the look; simulated time in nanoseconds by default.
    """
    model = model or ForwardLooking()
    pose = checked_pose(world_from_sonar)
    core = core_model(sim, model, ForwardLooking)
    level_db = _core.forward_look(
        core, sim.scene, sim.world.water, *split_pose(pose), sim.seed, name, _number(sim, number), sim.threads
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
    core = core_model(sim, model, SideScan)
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
    core = core_model(sim, model, SingleBeam)
    level_db, ranges_m = _core.single_beam(
        core, sim.scene, sim.world.water, *split_pose(pose), angles, sim.seed, name, _whole(first_ping, "first_ping"),
        sim.threads,
    )  # fmt: skip
    noise_db = _noise_db(model, core, sim, float(pose[2, 3]))
    return Profiles(level_db, noise_db, ranges_m, angles, model.bin_centres_m, pose, model)


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
