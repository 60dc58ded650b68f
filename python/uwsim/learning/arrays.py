"""Checks of arrays with one row per member; errors name the method that returned them, the member and the value."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats


def rows(where: str, name: str, values: Any, shape: tuple[int, ...], members: NDArray[np.intp] | None = None) -> Floats:
    """Return values as a float64 array of this shape. Raises ValueError, naming the member, if a value is not finite.

    members: the members to which the rows belong; by default all.
    """
    array = np.asarray(values)
    require_shape(where, name, array, shape)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{where}: {name}.dtype = {array.dtype}: must be float64")
    finite = np.isfinite(array)
    if not finite.all():
        row, *at = np.argwhere(~finite)[0].tolist()
        member = row if members is None else int(members[row])
        raise ValueError(f"{where}: member {member}, {name}{at or ''} = {array[(row, *at)]}: must be finite")
    return array.astype(np.float64, copy=False)


def require_shape(where: str, name: str, array: NDArray[Any], shape: tuple[int, ...]) -> None:
    """Raise ValueError unless the array has this shape."""
    if array.shape != shape:
        raise ValueError(f"{where}: {name}.shape = {array.shape}: must be {shape}")
