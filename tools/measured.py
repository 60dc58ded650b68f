"""Keep the figures of speed equal everywhere: `python -m tools.measured write`; `survey` measures it first.

docs/inside/measured.json is their one home. In the pages below, the word or the code in backticks before a comment such
as <!--survey.times--> is the value of that name.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tools.history import machine

ROOT = Path(__file__).resolve().parents[1]
VALUES = ROOT / "docs/inside/measured.json"
PAGES = [ROOT / name for name in ("README.md", "docs/index.md", "docs/inside/performance.md", "docs/paper/paper.md")]
MARKED = re.compile(r"(`[^`]*`|[\w.]+)<!--(\w+)\.(\w+)-->")


def filled(text: str, values: dict[str, dict[str, Any]]) -> str:
    """Return a page with every marked word replaced by its value. Raises KeyError for an unknown name."""

    def value(match: re.Match[str]) -> str:
        new = f"{values[match[2]][match[3]]}"
        return f"{f'`{new}`' if match[1].startswith('`') else new}<!--{match[2]}.{match[3]}-->"

    return MARKED.sub(value, text)


def measure_survey(values: dict[str, Any]) -> None:
    """Replace the survey's figures by those of its command, run here and now."""
    with tempfile.TemporaryDirectory() as folder:
        found = Path(folder) / "survey.json"
        subprocess.run([*values["command"].split(), "--json", found], check=True)
        result = json.loads(found.read_text())
    cpu = machine()
    values |= {
        "minutes": round(result["simulated_s"] / 60.0),
        "seconds": round(result["wall_s"], 1),
        "times": int(float(f"{result['real_time_factor']:.2g}")),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "machine": f"{cpu['processor']}, {cpu['cores']} cores",
    }


def main() -> None:
    """Measure if asked to, and write the pages."""
    values = json.loads(VALUES.read_text())
    if sys.argv[1:] == ["survey"]:
        measure_survey(values["survey"])
        VALUES.write_text(json.dumps(values, indent=1) + "\n")
    elif sys.argv[1:] != ["write"]:
        sys.exit(__doc__)
    for page in PAGES:
        page.write_text(filled(page.read_text(), values))


if __name__ == "__main__":
    main()
