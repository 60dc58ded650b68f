"""Validates the per-member arguments of a batch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from uwsim.base.axes import AXES
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fault import FaultModel, FaultSpec
from uwsim.scenario.spec.fields import Model

Changes = Mapping[str, Any]
FaultList = Sequence[Mapping[str, Any]]
FASTEST = 100.0  # sim/placement.cpp


class _Faults(Model):
    """Validates faults passed as arguments rather than in a file."""

    faults: Annotated[tuple[FaultSpec, ...], Field(max_length=1000)]


def require_possible(where: object, times_s: NDArray[np.float64], velocity_body: NDArray[np.float64]) -> None:
    """Raise ValueError for a measured speed [m/s] or rate [rad/s], NaN or (n, 6), at which no vehicle can be placed."""
    for row, axis in np.argwhere(np.abs(velocity_body) > FASTEST):
        speed = f"{AXES[axis]} at {velocity_body[row, axis]:g} {'m/s' if axis < 3 else 'rad/s'}"
        raise ValueError(f"{where}: at {times_s[row]:.12g} s, {speed}: must be within {FASTEST:g}")


def whole(value: Any, name: str, least: int, most: int) -> int:
    """Return a whole number in [least, most]. Raises ValueError."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise ValueError(f"{name} = {value!r:.60}: must be a whole number in [{least}, {most}]")
    return int(value)


def seeds(values: Iterable[Any], n: int, chosen: Iterable[int]) -> dict[int, int]:
    """Return the seeds of the selected members, keyed by index. n: the number of members. Raises ValueError."""
    given = list(values)
    if len(given) != n:
        raise ValueError(f"seeds: {len(given)} of them: expected n = {n}")
    return {k: whole(given[k], f"seeds[{k}]", 0, 2**63 - 1) for k in chosen}


def changes(given: Changes | Sequence[Changes], n: int, chosen: Iterable[int]) -> dict[int, dict[str, Any]]:
    """Return the parameters of each selected member. A single mapping applies to all n members. Raises ValueError."""
    each = [given] * n if isinstance(given, Mapping) else given
    if len(each) != n:
        raise ValueError(f"parameters: {len(each)} mappings: expected one, or n = {n}")
    return {k: _mapping(each[k], f"parameters[{k}]") for k in chosen}


def faults(given: FaultList | Sequence[FaultList], n: int, chosen: Iterable[int]) -> dict[int, tuple[FaultModel, ...]]:
    """Return the faults of each selected member. A single list applies to all n members. Raises ValueError."""
    if isinstance(given, str | Mapping) or not isinstance(given, Sequence):
        raise ValueError(f"faults is {type(given).__name__}: must be a list of faults, or n of them")
    if all(isinstance(one, Mapping) for one in given):
        for_all = _read(given, "")
        return dict.fromkeys(chosen, for_all)
    if len(given) != n:
        raise ValueError(f"faults: {len(given)} lists: expected one, or n = {n}")
    return {k: _read(given[k], f"batch[{k}]: ") for k in chosen}


def _read(one: object, where: str) -> tuple[FaultModel, ...]:
    try:
        return validated(_Faults, {"faults": one}).faults
    except ValueError as error:
        raise ValueError(f"{where}{error}") from None


def _mapping(one: object, name: str) -> dict[str, Any]:
    if not isinstance(one, Mapping):
        raise ValueError(f"{name} is {type(one).__name__}: must be a mapping of names to values")
    return dict(one)


def rows(values: ArrayLike, name: str, n: int, width: int) -> NDArray[np.float64]:
    """Return an array (n, width) of numbers. A single row applies to all members. Raises ValueError."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}.dtype = {array.dtype}: must be real numbers")
    if array.shape not in ((width,), (n, width)):
        raise ValueError(f"{name}.shape = {array.shape}: expected ({n}, {width}) or ({width},)")
    return np.broadcast_to(array.astype(np.float64), (n, width))


def each(values: ArrayLike, name: str, n: int) -> NDArray[np.float64]:
    """Return n finite numbers. A single number applies to all members. Raises ValueError."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}.dtype = {array.dtype}: must be real numbers")
    if array.shape not in ((), (n,)):
        raise ValueError(f"{name}.shape = {array.shape}: expected ({n},) or a number")
    found = np.broadcast_to(array.astype(np.float64), (n,))
    require_finite(found, name)
    return found


def require_finite(values: NDArray[np.float64], name: str) -> None:
    """Raise ValueError if values are not finite. The message names the first such member."""
    for where in np.argwhere(~np.isfinite(values))[:1]:
        at = "".join(f"[{k}]" for k in where.tolist())
        raise ValueError(f"{name}{at} = {values[tuple(where)]}: must be finite")


def members(mask: ArrayLike | None, n: int) -> list[int]:
    """Return the indices of the members selected by a mask (n,) bool, or all without one. Raises ValueError."""
    if mask is None:
        return list(range(n))
    chosen = np.asarray(mask)
    if chosen.dtype != np.bool_ or chosen.shape != (n,):
        raise ValueError(f"mask: {chosen.dtype} {chosen.shape}: expected bool ({n},)")
    return [int(k) for k in np.flatnonzero(chosen)]
