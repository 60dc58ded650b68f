"""A disk cache for results that are slow to compute: arrays, such as closed hulls and noise terrain, and parsed YAML.

The folder is $UWSIM_CACHE if set (empty: no cache), otherwise uwsim in $XDG_CACHE_HOME or ~/.cache. File names are
digests of everything that the results depend on: inputs, our sources and library versions. The folder may be deleted at
any time. If a file is damaged, unwritable or owned by another user, its content is computed again.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import math
import os
import re
import sys
import warnings
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from uwsim.base import texts
from uwsim.base.atomic_file import write_atomically
from uwsim.base.caught_warnings import caught_warnings
from uwsim.base.texts.json_text import json_value

Arrays = tuple[NDArray[np.generic], ...]
Input = str | bytes | float | NDArray[np.generic]
R = TypeVar("R")

MAX_FILE_BYTES, MAX_FOLDER_BYTES, CHECK_EVERY_BYTES = 1 << 26, 1 << 29, 1 << 24
SUFFIX = ".cached"
LIBRARIES = ("numpy", "scipy", "trimesh", "networkx", "manifold3d", "assimp-py", "ruamel-yaml")
DIGEST_BYTES = 32
NAME = re.compile(rf"[\w-]+-[0-9a-f]{{{2 * DIGEST_BYTES}}}{re.escape(SUFFIX)}")
"""The files' names, with the digest of what their content depends on: no file of anybody else has such a name."""

_unchecked_bytes: dict[Path, int] = {}
"""Bytes that this process has written to each folder since it last checked the folder's size."""


def cached_arrays(make: Callable[[], Arrays], kind: str, *inputs: Input) -> Arrays:
    """Return make(), or the arrays stored by an earlier call with the same inputs.

    kind: a name for this kind of array. Results computed with warnings are not stored, so that the warnings are issued
    every time.
    """
    return _cached(make, _packed, _unpacked, kind, inputs)


def cached_json(make: Callable[[], Any], kind: str, *inputs: Input) -> Any:
    """Do the same for a JSON value."""
    return _cached(make, lambda value: json.dumps(value, ensure_ascii=False).encode(), _json, kind, inputs)


def _cached(
    make: Callable[[], R], pack: Callable[[R], bytes], unpack: Callable[[bytes], R], kind: str,
    inputs: tuple[Input, ...],
) -> R:  # fmt: skip
    folder = _folder()
    if folder is None:
        return make()
    path = folder / f"{kind}-{_digest_of(kind, *inputs)}{SUFFIX}"
    with contextlib.suppress(OSError, ValueError, TypeError):
        return unpack(_checked(path.read_bytes()))
    with caught_warnings() as issued:
        result = make()
    for warning in issued:
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if not issued:
        with contextlib.suppress(OSError, ValueError):  # ValueError: JSON cannot hold the value
            _keep(path, pack(result))
    return result


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
    path.parent.mkdir(parents=True, exist_ok=True)
    unchecked = _unchecked_bytes.get(path.parent, CHECK_EVERY_BYTES) + len(content)
    if unchecked > CHECK_EVERY_BYTES:  # a folder may contain thousands of files
        _make_room(path.parent, MAX_FOLDER_BYTES - len(content))
        unchecked = 0
    _unchecked_bytes[path.parent] = unchecked
    # a damaged file of ours is replaced: see NAME
    write_atomically(path, _checksum(content) + content, replaces_any=True, flushes=False)


def _make_room(folder: Path, limit_bytes: int) -> None:
    """Remove the oldest files until the rest are within the limit, but none whose content is not ours."""
    kept = (path for path in folder.iterdir() if NAME.fullmatch(path.name))
    files = sorted(((p.stat().st_mtime, p.stat().st_size, p) for p in kept), reverse=True)
    total = 0
    for _, size, path in files:
        total += size
        if total > limit_bytes:
            with contextlib.suppress(OSError, ValueError):
                _checked(path.read_bytes())
                path.unlink()


def _json(data: bytes) -> Any:
    return json_value(data, "a cached file")


def _checksum(content: bytes | memoryview) -> bytes:
    return zlib.crc32(content).to_bytes(4, "little")


def _checked(data: bytes) -> bytes:
    """Return a file's content. Raises ValueError if it is damaged."""
    content = data[4:]
    if data[:4] != _checksum(content):
        raise ValueError("damaged")
    return content


def _packed(arrays: Arrays) -> bytes:
    """Return a line with types and shapes, followed by the arrays' bytes."""
    header = json.dumps([(array.dtype.str, array.shape) for array in arrays])
    return b"".join([header.encode(), b"\n", *(array.tobytes() for array in arrays)])


def _unpacked(data: bytes) -> Arrays:
    begin = data.index(b"\n") + 1
    arrays = []
    for kind, shape in _json(data[: begin - 1]):
        arrays.append(np.ndarray(shape, kind, data, begin).copy())
        begin += math.prod(shape) * arrays[-1].itemsize
    return tuple(arrays)


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
    """Return a digest of the library versions and of our sources, since results depend on both."""
    digest = hashlib.blake2b(repr(sorted(_installed())).encode())
    scenario, base = Path(__file__).parents[1], Path(texts.__file__).parent
    for path in sorted(path for part in (scenario / "read", scenario / "build", base) for path in part.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.digest()


def _installed() -> Iterator[str]:
    """Yield the names of the libraries' metadata folders, which contain the versions.

    importlib.metadata takes ten times as long, since it parses the metadata.
    """
    for folder in dict.fromkeys(sys.path):
        with contextlib.suppress(OSError):
            for entry in os.scandir(folder or "."):
                library, dash, _ = entry.name.lower().partition("-")
                if dash and library.replace("_", "-").replace(".", "-") in LIBRARIES and entry.name.endswith("-info"):
                    yield entry.name
