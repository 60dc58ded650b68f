"""Merges several map files of one area into one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from uwsim.mapping.files.map_files import MAP_SUFFIXES, open_map, require_same_grid


def merge_files(sources: Sequence[Path], target: Path) -> int:
    """Write the sum of the maps' log-odds to `target`, .bt or .ot, atomically; returns its number of occupied voxels.

    The files hold no origin: all must have been written with the same one. The voxels of a .bt count with the clamping
    limits, so an .ot has the weight that was measured and a .bt the greatest possible. Raises ValueError, which names
    the file, or OSError, with nothing written.
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
