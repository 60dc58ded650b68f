"""A disk cache for arrays that are slow to compute, such as closed hulls and noise terrain.

The folder is $UWSIM_CACHE if set (empty: no cache), otherwise uwsim in $XDG_CACHE_HOME or ~/.cache. File names are
digests of everything that the arrays depend on: inputs, our sources and library versions. The folder may be deleted at
any time. If a file is damaged, unwritable or owned by another user, its arrays are recomputed.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import io
import os
import warnings
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.caught_warnings import caught_warnings
from uwsim.base.npz import read_npz

Arrays = tuple[NDArray[np.generic], ...]
Input = str | bytes | float | NDArray[np.generic]

MAX_FILE_BYTES, MAX_FOLDER_BYTES, CHECK_EVERY_BYTES = 1 << 26, 1 << 29, 1 << 24
LIBRARIES = ("numpy", "scipy", "trimesh", "networkx", "manifold3d", "assimp-py")
DIGEST_BYTES = 32

_unchecked_bytes: dict[Path, int] = {}
"""Bytes that this process has written to each folder since it last checked the folder's size."""


def cached_arrays(make: Callable[[], Arrays], kind: str, *inputs: Input) -> Arrays:
    """Return make(), or the arrays stored by an earlier call with the same inputs.

    kind: a name for this kind of array. Results computed with warnings are not stored, so that the warnings are issued
    every time.
    """
    folder = _folder()
    if folder is None:
        return make()
    path = folder / f"{kind}-{_digest_of(kind, *inputs)}.npz"
    with contextlib.suppress(OSError, ValueError, KeyError, EOFError):
        return _unpacked(path.read_bytes())
    with caught_warnings() as issued:
        arrays = make()
    for warning in issued:
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if not issued:
        _keep(path, _packed(arrays))
    return arrays


def _folder() -> Path | None:
    chosen = os.environ.get("UWSIM_CACHE")
    if chosen is not None:
        return Path(chosen) if chosen else None
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    with contextlib.suppress(RuntimeError):  # no home directory
        return Path(base).expanduser() / "uwsim"
    return None


def _keep(path: Path, content: bytes) -> None:
    if len(content) > MAX_FILE_BYTES:
        return
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        unchecked = _unchecked_bytes.get(path.parent, CHECK_EVERY_BYTES) + len(content)
        if unchecked > CHECK_EVERY_BYTES:  # a folder may contain thousands of files
            _make_room(path.parent, MAX_FOLDER_BYTES - len(content))
            unchecked = 0
        _unchecked_bytes[path.parent] = unchecked
        write_atomically(path, content)


def _make_room(folder: Path, limit_bytes: int) -> None:
    """Remove the oldest files until the rest are within the limit."""
    files = sorted(((p.stat().st_mtime, p.stat().st_size, p) for p in folder.glob("*.npz")), reverse=True)
    total = 0
    for _, size, path in files:
        total += size
        if total > limit_bytes:
            path.unlink(missing_ok=True)


def _packed(arrays: Arrays) -> bytes:
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **{f"a{k}": array for k, array in enumerate(arrays)})
    content = file.getvalue()
    return hashlib.blake2b(content, digest_size=DIGEST_BYTES).digest() + content


def _unpacked(data: bytes) -> Arrays:
    """Unpack the arrays. Raises ValueError if the bytes are damaged."""
    digest, content = data[:DIGEST_BYTES], data[DIGEST_BYTES:]
    if hashlib.blake2b(content, digest_size=DIGEST_BYTES).digest() != digest:
        raise ValueError("damaged")
    held = read_npz(content)
    return tuple(held[f"a{k}"] for k in range(len(held)))


def _digest_of(*inputs: Input) -> str:
    digest = hashlib.blake2b(_versions(), digest_size=DIGEST_BYTES)
    for value in inputs:
        if isinstance(value, np.ndarray):
            described, content = f"{value.dtype.str}{value.shape}", np.ascontiguousarray(value).tobytes()
        else:
            described, content = type(value).__name__, value if isinstance(value, bytes) else repr(value).encode()
        digest.update(f"{described}:{len(content)}:".encode() + content)
    return digest.hexdigest()


@functools.cache
def _versions() -> bytes:
    """Return the library versions and a digest of our sources, since results depend on both."""
    digest = hashlib.blake2b()
    for name in LIBRARIES:
        with contextlib.suppress(metadata.PackageNotFoundError):
            digest.update(f"{name} {metadata.version(name)} ".encode())
    scenario = Path(__file__).parent.parent
    for path in sorted(path for part in ("read", "build") for path in (scenario / part).glob("*.py")):
        digest.update(path.read_bytes())
    return digest.digest()
