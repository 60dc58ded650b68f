"""The page's modules that need no browser, under node."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from uwsim.operator.station.wire_js import messages_js

PROGRAMS = Path(__file__).parents[2] / "js"
NODE = Path(sys.prefix) / "bin/node"


# What each program checks is stated in it.
@pytest.mark.parametrize("program", ["station.mjs", "page.mjs"])
def test_the_page_without_a_browser(program, tmp_path):
    made = tmp_path / "messages.js"
    made.write_text(messages_js())
    command = [NODE, "--import", PROGRAMS / "made.mjs", PROGRAMS / program]
    environment = {**os.environ, "MESSAGES": made.as_uri()}
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
    assert done.returncode == 0, done.stderr
