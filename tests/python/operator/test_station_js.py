"""The page's modules that need no browser, under node."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
NODE = Path(sys.prefix) / "bin/node"


def test_a_page_knows_when_nothing_arrives_and_whether_it_had_the_controls():
    done = subprocess.run([NODE, ROOT / "tests/js/station.mjs"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
