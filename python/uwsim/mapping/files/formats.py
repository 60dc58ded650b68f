"""The formats of files of maps, clouds and depth grids, which packages register as entry points named by their suffix.

The group `uwsim.kinds.cloud_file` has the entry `ply`, and `CLOUD_FORMATS[".ply"]` is its object. Each format is one
file, which is imported when it is looked up; docs/inside/extend.md adds one from another package.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.reader import Reader, reader_of
from uwsim.base.sockets import load, load_all, registered

if TYPE_CHECKING:
    from uwsim.mapping.depth_grid import DepthGrid
    from uwsim.mapping.files.georeference import Georeference
    from uwsim.mapping.occupancy_map import OccupancyMap

Origin = tuple[float, float, float] | None  # None: the one that a file states, else zero


@dataclass(frozen=True)
class MapFileFormat:
    """A format of occupancy maps.

    content: what a file holds. read(path, origin_world_m): returns the map; raises OSError or ValueError. write(map,
    path): writes it atomically, as uwsim.base.atomic_file does. has_probabilities: whether a file distinguishes more
    than occupied and free.
    """

    content: str
    read: Callable[[Path, Origin], OccupancyMap]
    write: Callable[[OccupancyMap, Path], None]
    has_probabilities: bool = False


@dataclass(frozen=True, kw_only=True)
class CloudFormat(Reader):
    """A format of point clouds: a Reader of a file's bytes, which returns points and may raise any exception.

    encode: converts finite points (n, 3), n > 0, float32 or float64, to bytes; raises ValueError. text_mark: the part
    of a header that declares the numbers to be text; None if all files are binary. encode_at: like encode, in
    geographic coordinates, for points in a world with a place on Earth; None for a format that has no such coordinates.
    seen_from: returns where the points were seen from, (3,), or None if the file does not state it; None for a format
    that never does.
    """

    encode: Callable[[NDArray[np.floating]], bytes]
    text_mark: bytes | None = None
    encode_at: Callable[[NDArray[np.floating], Georeference], bytes] | None = None
    seen_from: Callable[[bytes], Floats | None] | None = None


@dataclass(frozen=True)
class GridFormat:
    """A format of depth grids, which are only written. write: does so atomically, as uwsim.base.atomic_file does."""

    write: Callable[[Path, DepthGrid, Georeference], None]


Format = TypeVar("Format")


class Formats(Mapping[str, Format], Generic[Format]):
    """The formats of a group of entry points, by suffix. Raises ValueError for one of a broken package."""

    def __init__(self, group: str, of: type[Format]) -> None:
        self._group, self._of = group, of

    def __getitem__(self, suffix: str) -> Format:
        if suffix not in self:
            raise KeyError(suffix)
        found: Format = load(self._group, suffix.removeprefix("."), self._fitting)
        return found

    def __contains__(self, suffix: object) -> bool:
        return suffix in list(self)

    def __iter__(self) -> Iterator[str]:
        return (f".{name}" for name in registered(self._group))

    def __len__(self) -> int:
        return len(registered(self._group))

    def usable(self) -> Mapping[str, Format]:
        """Return all formats by suffix but those of broken packages, of which it warns."""
        return {f".{name}": each for name, each in load_all(self._group, self._fitting).items()}

    def _fitting(self, name: str, found: Any) -> Any:
        if not isinstance(found, self._of):
            raise TypeError(f"must be a {self._of.__module__}.{self._of.__name__}")
        return found


CLOUDS = "uwsim.kinds.cloud_file"
MAP_FORMATS = Formats("uwsim.kinds.map_file", MapFileFormat)
CLOUD_FORMATS = Formats(CLOUDS, CloudFormat)
GRID_FORMATS = Formats("uwsim.kinds.grid_file", GridFormat)


def begins(pattern: bytes) -> Callable[[Path, bytes], bool]:
    """Return the `accepts` of a Reader of files whose first bytes match a pattern."""
    found = re.compile(pattern, re.DOTALL)
    return lambda path, head: found.match(head) is not None


def cloud_format(path: Path) -> CloudFormat | None:
    """Return the format of a cloud by its content; by its name, if no format accepts that; None for another file."""
    found = reader_of(CLOUDS, path) if path.is_file() else None
    return cast("CloudFormat | None", found or CLOUD_FORMATS.get(path.suffix.lower()))


def placed_clouds() -> list[str]:
    """Return the suffixes of the cloud formats that hold a place on Earth."""
    return [suffix for suffix, each in CLOUD_FORMATS.usable().items() if each.encode_at is not None]
