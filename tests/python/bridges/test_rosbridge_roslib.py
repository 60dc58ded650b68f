"""roslib 1.4 and 2.x under node against our rosbridge; tests/js/rosbridge.mjs makes the calls that users make."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from uwsim.bridges import RosbridgeServer

ROOT = Path(__file__).parents[3]
CLIENTS = ROOT / "build/js"  # installed by tools/setup --dev
NODE = Path(sys.prefix) / "bin/node"


@pytest.mark.parametrize("module", ["roslib1", "roslib2"])
def test_roslib(module):
    assert NODE.exists() and (CLIENTS / "node_modules" / module).is_dir(), "run tools/setup --dev"
    script = [str(NODE), str(ROOT / "tests/js/rosbridge.mjs")]
    with RosbridgeServer(None) as server:
        done = subprocess.run(
            [*script, server.url, str(CLIENTS), module], capture_output=True, text=True, timeout=300, check=False
        )
    assert done.returncode == 0, done.stderr
    lists, typed = ["base_scan", [1.5, 2.5], "Array"], ["base_scan", [1.5, 2.5], "Float32Array"]
    assert json.loads(done.stdout.splitlines()[-1]) == {
        "none": lists,
        "cbor": typed,
        "png": lists,
        "throttled": 1,
        "sum": 5,
        "missing": "service '/nobody': nobody offers it",
        "param_missing": None,
        "param": {"p": 1.5},
        "params": ["/gain"],
        "type": "sensor_msgs/LaserScan",
        "nodes": True,
        "fields": ["linear", "angular"],
        "x": 3,
        "status": "error",
        "again": "hello",
    }
