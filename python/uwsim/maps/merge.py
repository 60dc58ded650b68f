"""Several maps of one place made into one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from uwsim.maps.files import MAP_SUFFIXES, open_map, require_same_grid


def merge_files(sources: Sequence[Path], target: Path) -> int:
    """Write the sum of the maps' log-odds to `target`, .bt or .ot, atomically; returns its occupied voxels.

    The files hold no origin: they must be of one. A .bt counts with the limits of certainty, so an .ot weighs as it was
    measured and a .bt as much as it can. Raises ValueError, naming the file, or OSError, having written nothing.
    """
    if len(sources) < 2:
        raise ValueError(f"{len(sources)} map given: must be two or more to merge")
    if target.suffix not in MAP_SUFFIXES:
        raise ValueError(f"--out '{target}': must end in {' or '.join(MAP_SUFFIXES)}")
    merged = open_map(sources[0])
    for source in sources[1:]:
        other = open_map(source)
        try:
            require_same_grid(merged, other)
        except ValueError as error:
            raise ValueError(f"'{sources[0]}' and '{source}': {error}") from None
        merged.merge(other)
    merged.write(target)
    return merged.statistics().occupied_voxels
