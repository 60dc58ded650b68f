"""The profiling sonar: a pencil beam that a motor steps about the head's z axis; see single_beam.cpp."""

from __future__ import annotations

from dataclasses import dataclass
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
class SingleBeam(Acoustics):
    """A profiling sonar with one pencil beam. The defaults resemble the Imagenex 881L.

    [IM] Imagenex, data sheet 445-039: 675 kHz, 1.8 deg, 10 mm. The beam is conical here; the 881L's is a fan of 1.8 x
    20 deg. Values without a source are assumed. detection_db: minimum height of an echo's peak above the noise; lower
    echoes are discarded.
    """

    kind: ClassVar[str] = "single_beam"

    frequency_hz: float = 675e3  # [IM]
    source_level_db: float = 205.0
    noise_level_db: float = 55.0  # as for ForwardLooking, with 75 kHz and a directivity of 35 dB
    range_max_m: float = 20.0
    range_bins: int = 2000  # [IM]
    gain_db_decade: float = 20.0  # a round beam's footprint grows with the square of range
    beam_width_rad: float = float(np.radians(1.8))  # [IM]
    rays_across: int = 17
    detection_db: float = 15.0


@dataclass(frozen=True, eq=False, repr=False)
class Profiles:
    """The pings of a single-beam sonar, one per angle.

    level_db: (angles, bins) float32, dB re 1 uPa. noise_db: (bins,) float32, the mean level of the noise alone.
    ranges_m: (angles,) float32, inf if there is no echo. angles_rad: (angles,) float64, about the sonar's z axis,
    positive to port. bin_centres_m: (bins,) float64. world_from_sonar: (4, 4). labels: (angles, bins) uint16, if
    requested: the surface, by Simulator.label_names, whose mean echo is the strongest in each cell; 0 where none is
    above the noise.
    """

    level_db: Levels
    noise_db: Levels
    ranges_m: NDArray[np.float32]
    angles_rad: NDArray[np.float64]
    bin_centres_m: NDArray[np.float64]
    world_from_sonar: Floats
    model: SingleBeam
    labels: Labels | None = None

    def __repr__(self) -> str:
        angles, bins = self.level_db.shape
        return (
            f"<Profiles: {angles} angles x {bins} ranges to {self.model.range_max_m:g} m, {level_span(self.level_db)}>"
        )

    def plot(self) -> Figure:
        """Return a matplotlib Figure of the levels by direction and range, with the detections as dots."""
        from uwsim.instruments.sonars.imaging.pixels import shown_range
        from uwsim.instruments.sonars.imaging.plots import picture  # imported here, since matplotlib takes a second

        degrees = np.degrees(self.angles_rad)
        extent = (float(degrees.min()) - 0.5, float(degrees.max()) + 0.5, 0.0, self.model.range_max_m)
        levels = self.level_db[np.argsort(degrees)].T[::-1]
        limits_db = shown_range(self.level_db, self.noise_db[None])
        across, up = "direction, to port [deg]", "range [m]"
        figure = picture(levels, extent, limits_db, repr(self), across, up, is_square=False)
        figure.axes[0].plot(degrees, self.ranges_m, ".", color="#4cc9f0", markersize=3)
        return figure

    def _repr_png_(self) -> bytes:
        from uwsim.instruments.sonars.imaging.plots import png

        return png(self.plot())

    @property
    def points_world_m(self) -> NDArray[np.float64]:
        """The echo positions in the world, (angles, 3) float64, along the beam axes; NaN if there is no echo."""
        ranges = np.where(np.isfinite(self.ranges_m), self.ranges_m, np.nan).astype(np.float64)
        flat = np.stack([np.cos(self.angles_rad), np.sin(self.angles_rad), np.zeros(len(ranges))], axis=1)
        return np.asarray((flat * ranges[:, None]) @ self.world_from_sonar[:3, :3].T + self.world_from_sonar[:3, 3])


def profile(
    sim: Place, world_from_sonar: ArrayLike, angles_rad: ArrayLike, model: SingleBeam | None = None, *,
    name: str = "single_beam", first_ping: int = 0, with_labels: bool = False,
) -> Profiles:  # fmt: skip
    """Ping once at each angle (n,) about the sonar's z axis, measured from its x axis, positive to port.

    name: name of the sonar's random stream. Ping k has the number first_ping + k. with_labels: whether to include the
    surface shown in each cell. Raises ValueError if an argument is invalid.
    """
    model = model or SingleBeam()
    pose = checked_pose(world_from_sonar)
    angles = np.atleast_1d(np.asarray(angles_rad, np.float64))
    core = instrument(sim, model, SingleBeam)
    arrays = core.ping(
        sim.scene, sim.world.water, *split_poses(pose[None]), sim.seed, name, whole_number(first_ping, "first_ping"),
        sim.threads, angles, with_labels,
    )  # fmt: skip
    noise = noise_db(model, core, sim, float(pose[2, 3]))
    ranges, bins = arrays["ranges_m"], model.bin_centres_m
    return Profiles(arrays["level_db"], noise, ranges, angles, bins, pose, model, labels_of(arrays))


def _ping(
    sim: Place, world_from_sonar: Floats, model: SingleBeam, name: str, angles_rad: ArrayLike, with_labels: bool = False
) -> Profiles:
    return profile(sim, world_from_sonar, angles_rad, model, name=name, first_ping=sim.time_ns, with_labels=with_labels)


KIND = ImagingKind(SingleBeam, _ping)
