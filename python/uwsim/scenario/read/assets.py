"""The packaged assets, and lookup of files by name or relative path."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from uwsim.base.named import did_you_mean
from uwsim.base.sockets import load_all
from uwsim.scenario.read.errors import ScenarioError

GROUP = "uwsim.assets"
"""Functions that return a package's folder of assets."""
YAML_SUFFIXES = (".yaml", ".yml")


@cache
def assets_folder() -> Path:
    """Return the folder of packaged assets: in the package if installed, otherwise at the root of the repository."""
    package = Path(__file__).resolve().parents[2]
    candidates = [package / "assets", package.parents[1] / "assets"]
    for folder in candidates:
        if (folder / "scenarios").is_dir():
            return folder
    raise ScenarioError(f"uwsim's own assets are missing (looked in {_listed(candidates)}): install uwsim again")


def packaged(kind: str, *, own: bool = False) -> dict[str, Path]:
    """Return the files that can be loaded without a path by name, uwsim's first. own: only those.

    kind: a folder in the assets, such as "scenarios".
    """
    found: dict[str, Path] = {}
    for folder in load_all(GROUP, _folder, own=own).values():
        for path in sorted((folder / kind).glob("*.yaml")):
            found.setdefault(path.stem, path)
    return found


def _folder(name: str, found: Any) -> Path:
    folder = found()
    if not (isinstance(folder, Path) and folder.is_dir()):
        raise TypeError(f"{folder}: must be an existing folder, as a Path")
    return folder


def packaged_names(kind: str) -> list[str]:
    """Return the names that can be loaded without a path."""
    return list(packaged(kind))


def find_yaml(source: str | Path, kind: str) -> Path:
    """Return the YAML file for a packaged name or a path. Raises a ScenarioError that lists the known names."""
    text = str(source)
    if isinstance(source, str) and text in (own := packaged(kind, own=True)):
        return own[text]
    path = Path(source).expanduser()
    if path.is_file():
        return path
    names = packaged(kind)
    if isinstance(source, str) and text in names:
        return names[text]
    if path.is_dir():
        raise ScenarioError(
            f"{text}: is a folder, expected a YAML file or one of the packaged {kind}: {_listed(names)}"
        )
    if path.exists():
        raise ScenarioError(f"{text}: not a regular file")
    if path.suffix.lower() in YAML_SUFFIXES or len(path.parts) > 1:
        raise ScenarioError(f"{text}: no such file")
    singular = kind[:-3] + "y" if kind.endswith("ies") else kind.removesuffix("s")
    raise ScenarioError(
        f"unknown {singular} '{text}': expected one of {_listed(names)}, or the path of a YAML file"
        + did_you_mean(text, names)
    )


def find_asset(name: Path, folder: Path) -> Path | None:
    """Return a file named in a YAML file: relative to that file's folder or, failing that, packaged; else None."""
    for base in (folder, assets_folder()):
        path = base / name.expanduser()
        if path.is_file():
            return path.resolve()
    return None


def shown_name(path: Path) -> str:
    """Return a YAML file's name for messages: the bare name of a packaged file, otherwise the path."""
    return path.name if assets_folder() in path.parents else str(path)


def _listed(items: Iterable[object]) -> str:
    return ", ".join(str(item) for item in items)
