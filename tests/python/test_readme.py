"""The README's Python programs run as printed."""

import re
import subprocess
import sys
from pathlib import Path

README = Path(__file__).parents[2] / "README.md"


def output_of(folder: Path, text: str) -> str:
    """Run the README's Python program that contains a text; return what it prints."""
    programs = re.findall(r"^```python\n(.*?)^```$", README.read_text(), flags=re.DOTALL | re.MULTILINE)
    (program,) = [program for program in programs if text in program]
    run = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False, timeout=120
    )
    assert (run.returncode, run.stderr) == (0, "")
    return run.stdout


def test_the_readme_flies_and_pings(tmp_path: Path) -> None:
    assert "echoes, the nearest at" in output_of(tmp_path, "rov.sonar.ping()")


def test_the_readme_goes_live(tmp_path: Path) -> None:
    depths = output_of(tmp_path, "uwsim.live").splitlines()[:-1]
    assert 3 <= len(depths) <= 4
    assert float(depths[-1]) > float(depths[0])
