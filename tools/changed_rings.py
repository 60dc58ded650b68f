"""Print the test folders of the heart and of the add-ons that a change can reach: python -m tools.changed_rings BASE.

An add-on is reached by a change of its files or tests, or of an add-on that it needs. A change elsewhere, such as of
the core or of assets, reaches all; so does one of the heart, which all add-ons import.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import PurePosixPath

from tools.module_graph import HEART, ROOT, ring_of, rings

NO_TEST = re.compile(r"^(docs/|[^/]*\.md$|\.github/|tools/(bench|soak)/)")
"""Files that no test outside tests/python/whole reads."""


def main() -> int:
    """Print one folder a line."""
    listed = subprocess.run(
        ["git", "diff", "--name-only", sys.argv[1]], cwd=ROOT, capture_output=True, text=True, check=True
    )
    print("\n".join(folders(reached(listed.stdout.splitlines()))))
    return 0


def reached(names: Iterable[str]) -> set[str]:
    """Return the rings that a change of these files reaches, and always the heart."""
    changed = {ring for name in names if not NO_TEST.match(name) for ring in _rings_of(name)}
    if HEART in changed:
        return set(rings())
    return {name for name, ring in rings().items() if name == HEART or ring.needs & changed or name in changed}


def folders(chosen: set[str]) -> list[str]:
    """Return the folders of tests/python with the tests of these rings, and those of the whole."""
    rooms = [path.name for path in sorted((ROOT / "tests/python").iterdir()) if any(path.glob("test_*.py"))]
    return [f"tests/python/{room}" for room in rooms if set(_rings_of(f"tests/python/{room}/")) & (chosen | {HEART})]


def _rings_of(name: str) -> set[str]:
    """Return the rings of a file; the heart for one outside all."""
    parts = PurePosixPath(name).with_suffix("").parts
    if parts[:2] == ("python", "uwsim"):
        return {ring_of(".".join(parts[1:])) or HEART}
    if parts[:2] == ("tests", "python") and len(parts) > 2:
        inside = {ring for ring, each in rings().items() for room in each.rooms if room.split(".")[1] == parts[2]}
        return inside or {HEART}
    return {HEART}


if __name__ == "__main__":
    sys.exit(main())
