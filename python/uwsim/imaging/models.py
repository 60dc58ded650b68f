"""What the imaging sonars are: their figures, and where these come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Acoustics:
    """What the three hear with. Levels in dB re 1 uPa.

    source_level_db: at 1 m. noise_level_db: in the receiver's band behind its beam former. Surfaces scatter as the
    scenario's materials say, unless told here (Lambert's strength, per square metre at normal incidence):
    bottom_strength_db, solid_strength_db: of the terrain and of all solids; strengths_db: of single ones, by
    World.label_names. range_max_m is cut into range_bins, each a resolution cell. The gain is gain_db_decade log10 R +
    2 alpha R, alpha that of the water at the head (Francois and Garrison); time_varied_gain False leaves levels as
    received. looks: independent looks that a cell averages; 1 is full speckle (Rayleigh amplitude), 0 none.
    """

    frequency_hz: float
    source_level_db: float
    noise_level_db: float
    range_max_m: float
    range_bins: int
    bottom_strength_db: float | None = None
    solid_strength_db: float | None = None
    strengths_db: Mapping[str, float] = field(default_factory=dict)
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
