"""The side-scan sonar: a beam on each side, narrow along the track and wide across it; see side_scan.cpp."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.arrays import Floats
from uwsim.instruments.sonars.imaging.acoustics import (
    Acoustics,
    Labels,
    Levels,
    Place,
    instrument,
    labels_of,
    level_span,
    noise_db,
    whole_number,
)
from uwsim.instruments.sonars.poses import checked_pose, split_poses
from uwsim.scenario.spec.imaging_sonar import ImagingKind

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class SideScan(Acoustics):
    """A side-scan sonar. The defaults resemble the StarFish 450.

    [SF] starfishsonar.com, "What is a side scan sonar": beams 30 deg below the horizontal, most of the energy within 60
    deg. That page gives an along-track width of 2 deg; the default here is that of a longer array. Values without a
    source are assumed. planes: number of planes of rays across the track, spread over the beam's width. detection_db:
    level, relative to the noise, at which the first bottom return is taken to begin.
    """

    kind: ClassVar[str] = "side_scan"

    frequency_hz: float = 450e3  # from the instrument's name
    source_level_db: float = 210.0
    noise_level_db: float = 50.0  # as for ForwardLooking, with 15 kHz
    range_max_m: float = 50.0
    range_bins: int = 1000
    along_width_rad: float = float(np.radians(0.5))
    vertical_width_rad: float = float(np.radians(60.0))  # [SF], taken as two-way
    depression_rad: float = float(np.radians(30.0))  # [SF]
    planes: int = 3
    detection_db: float = 12.0


@dataclass(frozen=True, eq=False, repr=False)
class Waterfall:
    """Side-scan sonar pings along a track, one per row.

    port_db, starboard_db: (pings, bins) float32 over slant range, dB re 1 uPa. noise_db: (bins,) float32, the mean
    level of the noise alone, in the water at the first ping. ranges_m: (bins,) float64. altitude_m: (pings,) float32,
    range of the first bottom return, inf if there is none. world_from_sonar: (pings, 4, 4). port_labels,
    starboard_labels: (pings, bins) uint16, if requested: the surface, by Simulator.label_names, whose mean echo is the
    strongest in each cell; 0 where none is above the noise.
    """

    port_db: Levels
    starboard_db: Levels
    noise_db: Levels
    ranges_m: NDArray[np.float64]
    altitude_m: NDArray[np.float32]
    world_from_sonar: Floats
    model: SideScan
    port_labels: Labels | None = None
    starboard_labels: Labels | None = None

    def __repr__(self) -> str:
        pings, bins = self.port_db.shape
        reach = f"{self.model.range_max_m:g} m to either side"
        return f"<Waterfall: {pings} pings x {bins} ranges to {reach}, {level_span(self.picture_db())}>"

    def plot(self) -> Figure:
        """Return a matplotlib Figure of the lines over slant range, the first at the top, port on the left."""
        from uwsim.instruments.sonars.imaging.pixels import shown_range
        from uwsim.instruments.sonars.imaging.plots import picture  # imported here, since matplotlib takes a second

        reach_m, levels = self.model.range_max_m, self.picture_db()
        extent_m = (-reach_m, reach_m, len(levels) - 0.5, -0.5)
        limits_db = shown_range(levels, np.concatenate([self.noise_db[::-1], self.noise_db])[None])
        return picture(levels, extent_m, limits_db, repr(self), "slant range to starboard [m]", "ping", is_square=False)

    def _repr_png_(self) -> bytes:
        from uwsim.instruments.sonars.imaging.plots import png

        return png(self.plot())

    def picture_db(self) -> Levels:
        """Return the picture, (pings, 2 bins) float32: port, mirrored, on the left and starboard on the right."""
        return np.concatenate([self.port_db[:, ::-1], self.starboard_db], axis=1)

    def over_ground(self) -> Waterfall:
        """Return the same pings by ground range, r -> sqrt(r^2 - altitude^2), assuming a level bottom.

        This removes the water column. Pings without altitude and cells beyond the maximum range are NaN.
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


def look_aside(
    sim: Place, worlds_from_sonar: Sequence[ArrayLike] | Floats, model: SideScan | None = None, *,
    name: str = "side_scan", first_ping: int = 0, with_labels: bool = False,
) -> Waterfall:  # fmt: skip
    """Ping once from each pose (pings, 4, 4), x along the track. Raises ValueError if an argument is invalid.

    name: name of the sonar's random stream. Ping k has the number first_ping + k, so a track gives the same result
    whether it is pinged in one call or in several. with_labels: whether to include the surface shown in each cell.
    """
    model = model or SideScan()
    poses = np.array([checked_pose(pose, f"worlds_from_sonar[{k}]") for k, pose in enumerate(worlds_from_sonar)])
    poses = poses.reshape(-1, 4, 4)
    core = instrument(sim, model, SideScan)
    number = whole_number(first_ping, "first_ping")
    arrays = core.ping(sim.scene, sim.world.water, *split_poses(poses), sim.seed, name, number, sim.threads,
                       with_labels=with_labels)  # fmt: skip
    noise = noise_db(model, core, sim, float(poses[0, 2, 3]) if len(poses) else 0.0)
    port, starboard, altitude = arrays["port_db"], arrays["starboard_db"], arrays["altitude_m"]
    labels = labels_of(arrays, "port_labels"), labels_of(arrays, "starboard_labels")
    return Waterfall(port, starboard, noise, model.bin_centres_m, altitude, poses, model, *labels)


def _ping(sim: Place, world_from_sonar: Floats, model: SideScan, name: str, with_labels: bool = False) -> Waterfall:
    return look_aside(sim, [world_from_sonar], model, name=name, first_ping=sim.time_ns, with_labels=with_labels)


KIND = ImagingKind(SideScan, _ping)
