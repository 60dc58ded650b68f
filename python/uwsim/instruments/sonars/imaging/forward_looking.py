"""The forward-looking sonar: one broad transmission received in many narrow beams; see forward_looking.cpp."""

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

PLOT_PIXELS = 600


@dataclass(frozen=True, kw_only=True)
class ForwardLooking(Acoustics):
    """A forward-looking imaging sonar. The defaults resemble the Oculus M750d in its low-frequency mode.

    [OM] Blueprint Subsea, Oculus M-series user manual: 130 deg across, 20 deg vertical; [VR] VideoRay's training page
    about that sonar: 512 beams. Values without a source are assumed.
    """

    kind: ClassVar[str] = "forward_looking"

    frequency_hz: float = 750e3  # from the instrument's name
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
    rays_per_column: int = 112


@dataclass(frozen=True, eq=False, repr=False)
class SonarImage:
    """A picture taken by a forward-looking sonar.

    level_db: (bins, beams) float32, dB re 1 uPa, finite. noise_db: (bins,) float32, the mean level of noise alone.
    ranges_m (bins,), bearings_rad (beams,): float64, the centres of the cells; bearings are about the sonar's z axis
    and increase from starboard to port. world_from_sonar (4, 4). labels: (bins, beams) uint16, if requested: the
    surface with the strongest mean echo in each cell, numbered as in Simulator.label_names; 0 where no surface's echo
    is above the noise.
    """

    level_db: Levels
    noise_db: Levels
    ranges_m: NDArray[np.float64]
    bearings_rad: NDArray[np.float64]
    world_from_sonar: Floats
    model: ForwardLooking
    labels: Labels | None = None

    def __repr__(self) -> str:
        bins, beams = self.level_db.shape
        return (
            f"<SonarImage: {beams} beams x {bins} ranges to {self.model.range_max_m:g} m, {level_span(self.level_db)}>"
        )

    def plot(self) -> Figure:
        """Return a matplotlib Figure of the levels in the sonar's plane."""
        from uwsim.instruments.sonars.imaging.pixels import polar_pixels, shown_range
        from uwsim.instruments.sonars.imaging.plots import picture  # imported here, since matplotlib takes a second

        model, half_rad = self.model, 0.5 * self.model.field_of_view_rad
        fan = polar_pixels(self.level_db, model.range_max_m, model.field_of_view_rad, PLOT_PIXELS)
        half_m = model.range_max_m * float(np.sin(min(half_rad, 0.5 * np.pi)))
        back_m = min(model.range_max_m * float(np.cos(half_rad)), 0.0)
        extent_m = (-half_m, half_m, back_m, model.range_max_m)
        limits_db = shown_range(self.level_db, self.noise_db[:, None])
        return picture(fan.level_db, extent_m, limits_db, repr(self), "to starboard [m]", "ahead [m]")

    def _repr_png_(self) -> bytes:
        from uwsim.instruments.sonars.imaging.plots import png

        return png(self.plot())


def look_ahead(
    sim: Place, world_from_sonar: ArrayLike, model: ForwardLooking | None = None, *, name: str = "forward_looking",
    number: int | None = None, with_labels: bool = False,
) -> SonarImage:  # fmt: skip
    """Return a picture taken by a forward-looking sonar. Raises ValueError if an argument is invalid.

    name: name of the sonar's random stream. number: selects the picture's noise; defaults to the simulated time in
    nanoseconds. with_labels: whether to include the surface shown in each cell.
    """
    model = model or ForwardLooking()
    pose = checked_pose(world_from_sonar)
    core = instrument(sim, model, ForwardLooking)
    first_ping = sim.time_ns if number is None else whole_number(number, "number")
    arrays = core.ping(sim.scene, sim.world.water, *split_poses(pose[None]), sim.seed, name, first_ping, sim.threads,
                       with_labels=with_labels)  # fmt: skip
    half = model.field_of_view_rad / 2
    bearings = np.linspace(-half, half, model.beams) if model.beams > 1 else np.array([-half])
    noise = noise_db(model, core, sim, float(pose[2, 3]))
    return SonarImage(arrays["level_db"], noise, model.bin_centres_m, bearings, pose, model, labels_of(arrays))


def _ping(
    sim: Place, world_from_sonar: Floats, model: ForwardLooking, name: str, with_labels: bool = False
) -> SonarImage:
    return look_ahead(sim, world_from_sonar, model, name=name, with_labels=with_labels)


KIND = ImagingKind(ForwardLooking, _ping)
