"""Merges map files of the same area or parts of it; the resulting bytes do not depend on the order of the files."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from pathlib import Path

from uwsim.mapping.files.formats import MAP_FORMATS
from uwsim.mapping.files.map_files import map_format, open_map, require_same_grid
from uwsim.mapping.occupancy_map import OccupancyMap

WIDE = (1e-300, 1.0 - 1e-16)
"""Clamping limits of the intermediate sum, log-odds -690 to 36.7: ten maps at OctoMap's limit, 3.5, add up to less."""
OCCUPIED_WINS = (0.4999999, 1.0 - 1e-12)
"""Clamping limits with which one occupied voxel (27.6) outweighs any number of free voxels (-4e-7)."""


def merge_files(sources: Sequence[Path], target: Path) -> int:
    """Merge maps into `target` (.bt or .ot), written atomically; return the number of occupied voxels.

    If all files have probabilities, as an .ot does, the log-odds of each voxel are added, and the sum is clamped as it
    is for scans: as if one map had received all scans, apart from clamping in between. A .bt contains only states. If
    any file does, a voxel is therefore occupied if it is occupied in any map, else free if it is free in any. Voxels
    that are unknown in all maps stay unknown.

    Floating-point sums depend on the order of the terms, so the files are merged in the order of their digests, and the
    result depends only on their contents. The files contain no origin: all must have been written with the same origin.
    At most two maps are in memory at a time. Raises ValueError, which names the file, or OSError, in both cases before
    anything is written.
    """
    if len(sources) < 2:
        raise ValueError(f"{len(sources)} map given: must be two or more to merge")
    if target.suffix not in MAP_FORMATS:
        raise ValueError(f"--out '{target}': must end in {' or '.join(MAP_FORMATS)}")
    ordered = sorted(sources, key=_digest)
    has_states_alone = any(not MAP_FORMATS[map_format(path)].has_probabilities for path in ordered)
    merged = _any_occupied(ordered) if has_states_alone else _summed(ordered)
    merged.write(target)
    return merged.count().occupied


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, hashlib.blake2b).hexdigest()


def _summed(sources: Sequence[Path]) -> OccupancyMap:
    first = open_map(sources[0])
    total = OccupancyMap(first.resolution_m, first.origin_world_m, clamping=WIDE)
    for source in sources:
        _merge(total, open_map(source), sources[0], source)
    limited = OccupancyMap(first.resolution_m, first.origin_world_m)
    limited.merge(total)
    return limited


def _any_occupied(sources: Sequence[Path]) -> OccupancyMap:
    with tempfile.TemporaryDirectory(prefix="uwsim-merge-") as folder:
        states = Path(folder) / "states.bt"
        total = _states(sources[0], states)
        for source in sources[1:]:
            _merge(total, _states(source, states), sources[0], source)
        total.write(states)
        return open_map(states)


def _states(source: Path, scratch: Path) -> OccupancyMap:
    """Read a map without probabilities: any other than a .bt is first converted to one."""
    if map_format(source) != ".bt":
        open_map(source).write(scratch)
        source = scratch
    return OccupancyMap.read(source, clamping=OCCUPIED_WINS)


def _merge(into: OccupancyMap, other: OccupancyMap, first: Path, source: Path) -> None:
    try:
        require_same_grid(into, other)
    except ValueError as error:
        raise ValueError(f"'{first}' and '{source}': {error}") from None
    into.merge(other)
