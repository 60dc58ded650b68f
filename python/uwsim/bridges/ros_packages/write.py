"""Writes a folder of text files atomically, with a list of checksums that identifies it later."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

SUMS = "uwsim.sha256"
"""The file with the checksums, in the format of `sha256sum --check`."""


def write_sealed(folder: Path, files: Mapping[str, str]) -> None:
    """Write files, keyed by path, to a folder; on failure, the folder is unchanged.

    An existing folder is replaced if it is empty or unchanged since an earlier call. Raises OSError if it contains
    anything else, or cannot be written.
    """
    target = folder.resolve()
    _require_replaceable(folder)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}."))
    except OSError as error:
        raise OSError(f"--out {folder}: cannot be written: {error.strerror or error}") from error
    try:
        fresh, before = made / "new", made / "old"
        for name, text in {**files, SUMS: _sums(files)}.items():
            path = fresh / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            if text.startswith("#!"):
                mode = path.stat().st_mode
                path.chmod(mode | (mode & 0o444) >> 2)  # who may read it may run it
        if target.exists():
            target.rename(before)
        try:
            fresh.rename(target)
        except OSError:
            if before.exists():
                before.rename(target)
            raise
    except OSError as error:
        raise OSError(f"--out {folder}: cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _sums(files: Mapping[str, str]) -> str:
    return "".join(f"{hashlib.sha256(text.encode()).hexdigest()}  {name}\n" for name, text in files.items())


def _require_replaceable(folder: Path) -> None:
    """Raise OSError unless the folder is absent, empty or unchanged since it was written here."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise OSError(f"--out {folder}: is not a folder")
    sums = folder / SUMS
    lines = sums.read_text(encoding="utf-8", errors="replace").splitlines() if sums.is_file() else []
    expected = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink() or not (path.is_dir() or path == sums or _has(path, expected.get(name))):
            raise OSError(f"--out {folder}: '{name}' is not as uwsim wrote it: choose an empty or a new folder")


def _has(path: Path, digest: str | None) -> bool:
    return digest is not None and path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == digest
