"""HDF5 from anywhere: only what is in the file itself, and no more than a file of its size may hold.

HDF5 can lead out of a file, by external and soft links, external storage and virtual datasets: a pipe that is never
written stops a reader for good, and other files are read as numbers. It can also state any size, since chunks that were
never written occupy nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import require_regular
from uwsim.scenario.read.contained import run_contained

SIGNATURE = b"\x89HDF\r\n\x1a\n"
FREE_BYTES, BYTES_PER_BYTE = 16_000_000, 400
"""The most that is read from a file: so much, and so much for each of its bytes. A value counts 8 bytes."""
CHUNK_BYTES = 64_000_000
"""The largest chunk of a dataset that is smaller: it is unpacked whole."""
TEXTS = 1000
"""The most texts of any length in a dataset: each may be the same long one."""
PROCESS, PROCESS_CPU_S = Path(__file__).with_name("hdf5_process.py"), 5
"""The process that reads texts first, and its processor time."""
SHUFFLE, FLETCHER32 = 2, 3
"""HDF5's numbers of the filters that do not compress."""


class Hdf5Error(ValueError):
    """The file leads to other files, or states more than it holds."""


class InsideHdf5:
    """The datasets of an HDF5 file that are in the file itself."""

    def __init__(self, file: Any, path: Path) -> None:
        self._file, self._path = file, path
        self._left_bytes = FREE_BYTES + BYTES_PER_BYTE * path.stat().st_size

    def names(self) -> Iterator[str]:
        """Yield the names in the root, of whatever kind."""
        yield from self._file

    def has(self, path: str) -> bool:
        """Return whether there is anything by these names from the root. Raises Hdf5Error as `dataset` does."""
        return self._node(path) is not None

    def dataset(self, path: str) -> Any:
        """Return a dataset by its names from the root, or None. Raises Hdf5Error if it is not in the file itself."""
        import h5py

        node = self._node(path)
        if not isinstance(node, h5py.Dataset):
            return None
        _require_stored_here(path, node)
        return node

    def _node(self, path: str) -> Any:
        import h5py

        node = self._file
        for name in path.split("/"):
            if not isinstance(node, h5py.Group) or not node.id.links.exists(name.encode()):
                return None
            if node.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
                raise _linked(path)
            node = node[name]
        return node

    def attributes(self, dataset: Any, names: Iterable[str]) -> dict[str, Any]:
        """Return the attributes of a dataset with these names that are single values. Raises Hdf5Error."""
        given = dataset.attrs
        single = [name for name in names if name in given and prod(given.get_id(name).shape or ()) == 1]
        if texts := [name for name in single if given.get_id(name).dtype.hasobject]:
            self._require_texts(dataset.name, texts)
        return {name: given[name] for name in single}

    def values(self, path: str, dataset: Any) -> NDArray[Any]:
        """Return the values of a dataset. Raises Hdf5Error if they are more than a file of this size may hold."""
        count, width = dataset.size or 0, max(dataset.dtype.itemsize, 8)
        if dataset.dtype.hasobject and count > TEXTS:
            raise Hdf5Error(f"{path} has {count:,} texts: must be at most {TEXTS:,}")
        if dataset.dtype.hasobject:
            self._require_texts(path)
        if count * width > self._left_bytes:
            raise Hdf5Error(f"{path} has {count:,} values, too many for a file of this size")
        self._left_bytes -= count * width
        return np.asarray(dataset[()])

    def _require_texts(self, path: str, attributes: Iterable[str] = ()) -> None:
        """Raise Hdf5Error if a process with limits cannot read texts: of some, the library would never return."""
        asked = str(self._path), path, [*attributes]
        try:
            run_contained(PROCESS, "HDF5", *asked, reads=[self._path], cpu_s=PROCESS_CPU_S)
        except ValueError as error:
            raise Hdf5Error(f"is not readable: {error}") from None


@contextmanager
def inside_hdf5(path: Path, what: str) -> Iterator[InsideHdf5]:
    """Open a file. what: its role, for messages. Raises MissingExtraError, OSError."""
    need_extra("h5py", f"{what}, HDF5,")
    import h5py

    with h5py.File(path, "r") as file:
        yield InsideHdf5(file, path)


def require_inside(path: Path, what: str) -> None:
    """Require all of an HDF5 file to be in the file itself, for readers that follow whatever it leads to.

    what: its role, for messages. Does nothing for other formats. Raises Hdf5Error, MissingExtraError, OSError.
    """
    if not is_hdf5(path):
        return
    need_extra("h5py", f"{what}, HDF5,")
    import h5py

    def leading_out(name: bytes, link: Any) -> bytes | None:  # an error in it would not be passed on
        return None if link.type == h5py.h5l.TYPE_HARD else name

    def require_stored(name: str, node: Any) -> None:
        if isinstance(node, h5py.Dataset):
            _require_stored_here(name, node)

    try:
        with h5py.File(path, "r") as file:
            if (found := file.id.links.visit(leading_out, info=True)) is not None:
                raise _linked(found.decode(errors="replace"))
            file.visititems(require_stored)
    except Hdf5Error:
        raise
    except Exception as error:  # the reader raises anything for a damaged file
        raise Hdf5Error(f"is not readable: {' '.join(str(error).split())}") from None


def is_hdf5(path: Path) -> bool:
    """Return whether there is a signature where readers look for it: behind a user's block of 512 bytes, 1024, ..."""
    at, size = 0, path.stat().st_size
    with require_regular(path).open("rb") as file:
        while at < size:
            file.seek(at)
            if file.read(len(SIGNATURE)) == SIGNATURE:
                return True
            at = max(512, 2 * at)
    return False


def _linked(path: str) -> Hdf5Error:
    return Hdf5Error(f"{path} is a link: must be in the file itself")


def _require_stored_here(path: str, dataset: Any) -> None:
    """Raise Hdf5Error if a dataset's values are not all in its file, or its chunks could be of any size."""
    import h5py

    layout = dataset.id.get_create_plist()
    if layout.get_layout() == h5py.h5d.VIRTUAL or layout.get_external_count():
        raise Hdf5Error(f"{path} is stored in other files: must be in the file itself")
    if layout.get_layout() != h5py.h5d.CHUNKED:
        return
    packers = [k for k in range(layout.get_nfilters()) if layout.get_filter(k)[0] not in (SHUFFLE, FLETCHER32)]
    if len(packers) > 1:
        raise Hdf5Error(f"{path} is compressed {len(packers)} times: must be at most once")
    width = dataset.dtype.itemsize
    if prod(layout.get_chunk()) * width > max(CHUNK_BYTES, prod(dataset.shape) * width):
        raise Hdf5Error(f"{path} has chunks of {prod(layout.get_chunk()):,} values, larger than itself")
