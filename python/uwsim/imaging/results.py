"""What the imaging sonars give."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from uwsim.imaging.models import ForwardLooking, SideScan, SingleBeam
from uwsim.imaging.poses import Matrix

Levels = NDArray[np.float32]


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
