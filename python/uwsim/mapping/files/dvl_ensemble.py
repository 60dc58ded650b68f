"""The content of a file of a Doppler log: its head and its ensembles, one ping each of the bottom and of water cells.

A format's writer is `dvl` of its `SurveyFormat`. Angles in rad, attitude as in swath.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WaterCells:
    """Cells in which the velocity through the water is measured, below the instrument.

    first_m: centre of the first one. layer_m: begin and end of the reference layer of the water track.
    """

    count: int
    size_m: float
    first_m: float
    layer_m: tuple[float, float]


@dataclass(frozen=True, eq=False)
class DvlHead:
    """Values that hold for a whole file.

    slant_rad: of the four beams from the instrument's vertical. period_s: between pings.
    """

    vehicle: str
    sensor: str
    slant_rad: float
    period_s: float
    cells: WaterCells | None = None


@dataclass(frozen=True, eq=False)
class DvlEnsemble:
    """One ping. time_ns: since 1970, UTC.

    velocity_m_s (3,): of the instrument over the bottom, forward, starboard and up, nan without bottom lock.
    beam_velocities_m_s and beam_ranges_m (4,): along the beams, away from the instrument, and their lengths; nan for a
    lost beam. Beams follow each other by quarter turns to port, from one that looks ahead or up to half a turn from it.
    cells_m_s (cells, 3) and water_track_m_s (3,): of the instrument through the water, in each cell and in the
    reference layer, axes as for velocity_m_s, nan where it is lost; None for a ping without cells.
    """

    time_ns: int
    heading_rad: float
    pitch_rad: float
    roll_rad: float
    depth_m: float
    sound_speed_m_s: float
    salinity_psu: float
    temperature_deg_c: float
    pressure_pa: float
    velocity_m_s: Array
    beam_velocities_m_s: Array
    beam_ranges_m: Array
    cells_m_s: Array | None = None
    water_track_m_s: Array | None = None


class DvlWriter(Protocol):
    """Writes one file: nothing is there under its name before `close`."""

    def add(self, ensemble: DvlEnsemble) -> None:
        """Append an ensemble. Raises OSError."""

    def close(self) -> None:
        """Complete the file. Raises OSError."""

    def discard(self) -> None:
        """Remove what was written."""
