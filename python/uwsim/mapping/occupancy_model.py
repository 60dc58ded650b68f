"""OctoMap's sensor model: how much an observation changes the log-odds of a voxel, and their limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class OccupancyModel:
    """OctoMap's sensor model (Hornung et al. 2013) as probabilities; the defaults are OctoMap's.

    hit: probability that a voxel with a point in it is occupied, in [0.5, 1). miss: the same for a voxel that a ray
    passes through, in (0, 0.5]. clamping: the lowest and the highest probability that scans can give a voxel.
    """

    hit: float = 0.7
    miss: float = 0.4
    clamping: tuple[float, float] = (0.1192, 0.971)


def probability(log_odds: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return 1 / (1 + exp(-log_odds)); NaN stays NaN."""
    return 1.0 / (1.0 + np.exp(-log_odds.astype(np.float64)))
