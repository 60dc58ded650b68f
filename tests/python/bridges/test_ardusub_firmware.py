"""A compiled ArduSub flies in all its modes; needs the program, whose path is in UWSIM_ARDUSUB."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BINARY, DEFAULTS = os.environ.get("UWSIM_ARDUSUB", ""), os.environ.get("UWSIM_ARDUSUB_DEFAULTS", "")


@pytest.mark.skipif(not BINARY, reason="UWSIM_ARDUSUB does not name a compiled ArduSub")
def test_a_compiled_ardusub_flies_in_all_its_modes_the_same_twice() -> None:
    pytest.importorskip("pymavlink", reason="needs the extra mavlink")
    command = [str(ROOT / "tools/trial"), "ardusub", "--binary", BINARY, "--defaults", DEFAULTS]
    trial = subprocess.run(command, capture_output=True, text=True, timeout=800, check=False)
    assert trial.returncode == 0, trial.stdout + trial.stderr
