"""The packaged assets, and lookup of files by name or relative path."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from uwsim.base.did_you_mean import did_you_mean
from uwsim.scenario.read.errors import ScenarioError

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


def packaged_names(kind: str) -> list[str]:
    """Return the names that can be loaded without a path. kind: a folder in the assets, such as "scenarios"."""
    return sorted(path.stem for path in (assets_folder() / kind).glob("*.yaml"))


def find_yaml(source: str | Path, kind: str) -> Path:
    """Return the YAML file for a packaged name or a path. Raises a ScenarioError that lists the known names."""
    text = str(source)
    names = packaged_names(kind)
    if isinstance(source, str) and text in names:
        return assets_folder() / kind / f"{text}.yaml"
    path = Path(source).expanduser()
    if path.is_file():
        return path
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
