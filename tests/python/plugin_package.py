"""The package of tests/plugin, installed as its users would."""

import os
import subprocess
import sys
from pathlib import Path

from docs_pages import ROOT

PLUGIN = ROOT / "tests" / "plugin"


def installed_plugin(folder: Path) -> Path:
    """Install the package into a folder, and return the folder."""
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--target", str(folder)]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, str(PLUGIN)], check=True, timeout=300)
    return folder


def with_plugins(*folders: Path) -> dict[str, str]:
    """Return an environment in which the packages in these folders are installed."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, folders)), "COLUMNS": "110"}


def add_package(folder: Path, name: str, group: str, *entries: str) -> Path:
    """Make a folder in which a package is installed that registers entries such as 'toy = json:loads'."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "entry_points.txt").write_text("\n".join([f"[{group}]", *entries]))
    return folder
