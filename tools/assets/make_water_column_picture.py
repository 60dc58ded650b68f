"""Draw docs/guides/water-column.png with the example code of docs/guides/sonars.md."""

import os
import re
import shutil
import tempfile
from pathlib import Path

GUIDE = Path(__file__).resolve().parents[2] / "docs/guides/sonars.md"
examples = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
(example,) = [code for code in examples if "water_column=True" in code]
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    exec(example)  # the guide's own code
    shutil.move("water_column.png", GUIDE.parent / "water-column.png")
