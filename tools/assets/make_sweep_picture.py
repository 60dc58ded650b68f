"""Draw docs/guides/sweep.png: run the sweep of sweeps.md, and save its sensitivity plot for coverage."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

DOCS = Path(__file__).parents[2] / "docs"


def first_program(page: str, language: str) -> str:
    """Return the page's first code block in a language."""
    found = re.search(rf"^```{language}\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    if found is None:
        sys.exit(f"make_sweep_picture: docs/guides/sweeps.md has no {language} program")
    return found.group(1)


def main() -> None:
    """Run the sweep, which takes a few minutes."""
    page = (DOCS / "guides" / "sweeps.md").read_text()
    with TemporaryDirectory() as folder:
        (Path(folder) / "mow.py").write_text(first_program(page, "python"))
        (Path(folder) / "overlap.yaml").write_text(first_program(page, "yaml"))
        subprocess.run(["uwsim", "sweep", "overlap.yaml", "--out", "runs"], cwd=folder, check=True)
        shutil.copy(Path(folder) / "runs" / "effects.png", DOCS / "guides" / "sweep.png")


if __name__ == "__main__":
    main()
