"""Reading of HDF5: the script of a contained process; to start quickly, it imports no uwsim.

HDF5 can lead out of a file, by links, external storage and virtual datasets: these are refused on every kernel, since a
pipe that is never written would stop a reader for good. It can also state any size, since chunks that were never
written occupy nothing, and its library never returns from some damaged heaps of texts: the process has limits.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

FREE_BYTES, BYTES_PER_BYTE = 16_000_000, 400
"""The most that is read from a file: so much, and so much for each of its bytes. A value counts 8 bytes."""


def require_inside(file: h5py.File) -> None:
    """Require all of a file to be in the file itself. Raises ValueError."""

    def leading_out(name: bytes, link: Any) -> bytes | None:  # an error in it would not be passed on
        return None if link.type == h5py.h5l.TYPE_HARD else name

    def require_stored(name: str, node: Any) -> None:
        layout = node.id.get_create_plist() if isinstance(node, h5py.Dataset) else None
        if layout and (layout.get_layout() == h5py.h5d.VIRTUAL or layout.get_external_count()):
            raise ValueError(f"{name} is stored in other files: must be in the file itself")

    if (found := file.id.links.visit(leading_out, info=True)) is not None:
        raise ValueError(f"{found.decode(errors='replace')} is a link: must be in the file itself")
    file.visititems(require_stored)


def read(path: str, names: list[str], attributes: list[str]) -> dict[str, Any]:
    """Return the datasets in the root that have one of these names, or standard names.

    The `names` of all, and of each by its number its `values`, its `axes` and those `attributes` that are single texts
    or numbers. Raises ValueError.
    """
    found: dict[str, Any] = {"names": []}
    left_bytes = FREE_BYTES + BYTES_PER_BYTE * Path(path).stat().st_size
    with h5py.File(path, "r") as file:
        require_inside(file)
        for name, each in file.items():
            if not isinstance(each, h5py.Dataset) or each.size is None:
                continue
            given = {key: np.asarray(each.attrs[key]) for key in attributes if key in each.attrs}
            given = {key: value.astype("S" if value.dtype == object else value.dtype) for key, value in given.items()}
            known = {key: value for key, value in given.items() if value.size == 1 and value.dtype.kind in "biufSU"}
            standard = str(np.char.decode(known.get("standard_name", np.array(b"")).astype("S"), "utf-8", "replace"))
            if name not in names and standard not in names:
                continue
            left_bytes -= each.size * max(each.dtype.itemsize, 8)
            if left_bytes < 0:
                raise ValueError(f"{name} has {each.size:,} values, too many for a file of this size")
            axes = [axis[0].name.strip("/") if len(axis) else "" for axis in each.dims]
            if each.is_scale and each.ndim == 1 and axes == [""]:
                axes = [name]
            values = each[()]
            at = f"{len(found['names'])} "
            found |= {at + "values": values.astype("S") if each.dtype.hasobject else values, at + "axes": axes}
            found |= {at + key: value for key, value in known.items()}
            found["names"].append(name)
    return {key: np.asarray(value, str if key.endswith(("names", "axes")) else None) for key, value in found.items()}
