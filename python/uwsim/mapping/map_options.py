"""The options of an OccupancyMap: OctoMap's sensor model, and engines by name, with the core's options for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from uwsim import _core


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


MapEngine = Literal["bricks", "octomap"]
InstructionSet = Literal["best", "portable", "avx2", "avx512"]
OnOutside = Literal["raise", "count"]

ENGINES = {"bricks": _core.MapEngine.BRICKS, "octomap": _core.MapEngine.OCTOMAP}
INSTRUCTION_SETS = {
    "best": _core.InstructionSet.BEST,
    "portable": _core.InstructionSet.PORTABLE,
    "avx2": _core.InstructionSet.AVX2,
    "avx512": _core.InstructionSet.AVX512,
}
ON_OUTSIDE = ("raise", "count")


def map_options(
    engine: str,
    model: OccupancyModel,
    instruction_set: str,
    on_outside: str,
) -> _core.MapOptions:
    """Return the core's options; see OccupancyMap. Raises ValueError for an unknown name."""
    for name, value, known in (
        ("engine", engine, ENGINES),
        ("instruction_set", instruction_set, INSTRUCTION_SETS),
        ("on_outside", on_outside, ON_OUTSIDE),
    ):
        if value not in known:
            raise ValueError(f"map.{name} = {value!r}: must be one of {', '.join(known)}")
    lowest, highest = model.clamping
    return _core.MapOptions(
        engine=ENGINES[engine],
        hit=model.hit,
        miss=model.miss,
        clamping_min=lowest,
        clamping_max=highest,
        instruction_set=INSTRUCTION_SETS[instruction_set],
        count_outside=on_outside == "count",
    )
