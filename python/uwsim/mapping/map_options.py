"""The engines and other options of an OccupancyMap, as names, and the core's options for them."""

from __future__ import annotations

from typing import Literal

from uwsim import _core
from uwsim.mapping.occupancy_model import OccupancyModel

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
