"""The page's modules that need no browser, under node."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
NODE = Path(sys.prefix) / "bin/node"


# What each program checks is stated in it.
@pytest.mark.parametrize("program", ["station.mjs", "page.mjs", "tables.mjs", "literals.mjs"])
def test_the_page_without_a_browser(program):
    done = subprocess.run([NODE, ROOT / "tests/js" / program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
