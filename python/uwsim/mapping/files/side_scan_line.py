"""The content of a side-scan file: the head of a survey and its lines, one ping to both sides, as its formats have it.

A format's writer is `side_scan` of its `SurveyFormat`. Angles in rad, axes as in swath.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats

Levels = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class SideScanHead:
    """Values that hold for a whole survey.

    bins: samples of each side, over slant ranges from 0 to range_max_m. along_width_rad and vertical_width_rad: of a
    beam; depression_rad: of its axis below the horizontal. offset_m (3,): the sonar from the vehicle's reference point,
    vehicle's axes. comment: one line about the source.
    """

    vehicle: str
    sonar: str
    frequency_hz: float
    range_max_m: float
    bins: int
    along_width_rad: float
    vertical_width_rad: float
    depression_rad: float
    offset_m: Floats
    comment: str


@dataclass(frozen=True, eq=False)
class SideScanLine:
    """One ping. Places are of the vehicle's reference point and of the sonar; depths below the water surface.

    time_ns: since 1970, UTC. altitude_m: range of the first return from the bottom, nan without one. port_db,
    starboard_db (bins,): levels re 1 uPa, the nearest sample first. Angles are the sonar's: heading from true north.
    """

    time_ns: int
    vehicle_deg: tuple[float, float]
    sonar_deg: tuple[float, float]
    sonar_depth_m: float
    altitude_m: float
    heading_rad: float
    pitch_rad: float
    roll_rad: float
    speed_m_s: float
    sound_speed_m_s: float
    port_db: Levels
    starboard_db: Levels


class SideScanWriter(Protocol):
    """Writes one file: nothing is there under its name before `close`."""

    def add(self, line: SideScanLine) -> None:
        """Append a line. Raises OSError."""

    def close(self) -> None:
        """Complete the file. Raises OSError."""

    def discard(self) -> None:
        """Remove what was written."""
