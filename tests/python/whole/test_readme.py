"""The README's Python programs run as printed."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from docs_pages import ROOT, blocks
from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator


def output_of(folder: Path, text: str, changes: dict[str, str] | None = None) -> str:
    """Run the README's Python program that contains a given text, with changes; return its output."""
    (program,) = [program for program in blocks(ROOT / "README.md", "python") if text in program]
    for old, new in (changes or {}).items():
        assert old in program
        program = program.replace(old, new)
    run = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False, timeout=600
    )
    assert (run.returncode, run.stderr) == (0, "")
    return run.stdout


def test_the_readme_reads_sensors(tmp_path: Path) -> None:
    assert "echoes, the nearest at" in output_of(tmp_path, "rov.sonar.ping()")


def test_the_readme_drives_by_roslibpy(tmp_path: Path) -> None:
    with LiveSimulator("lake") as live, RosbridgeServer(live) as server:
        start_m = live.simulator.rov.pose.position_world_m
        changes = {"9090": str(server.port), "range(100)": "range(25)"}
        ranges_m = [float(line) for line in output_of(tmp_path, "roslibpy", changes).splitlines()]
        moved_m = np.linalg.norm(live.simulator.rov.pose.position_world_m - start_m)
    assert len(ranges_m) > 20 and all(0.0 < range_m < 96.0 for range_m in ranges_m)
    assert moved_m > 0.1
