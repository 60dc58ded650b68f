"""Bubbles that rise from an obstacle, such as those of a leak."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.spec.material import Material

BUBBLES = Material.model_construct(kind="plain", colour=(0.80, 0.86, 0.88), strength_db=-11.0)
"""How bubbles look and echo. A bubble that is large compared with the wavelength has a^2 / 4 of backscattering cross
section (Medwin and Clay 1998, "Fundamentals of Acoustical Oceanography", 8.2), of pi a^2 of area: -11 dB."""


@dataclass(frozen=True, eq=False)
class BubblePlume:
    """A plume of bubbles. source_m (3,): where they leave the obstacle. rate_l_min: volume of gas, at its pressure."""

    source_m: NDArray[np.float64]
    rate_l_min: float
