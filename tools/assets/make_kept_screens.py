"""Draw fig04.jpg and fig05.jpg, the screenshots that `uwsim reproduce paper` uses on machines without a browser."""

from __future__ import annotations

import tempfile
from pathlib import Path

from PIL import Image

from uwsim.evidence.reproduce.screens import KEPT, NAMES, take_screens

QUALITY = 82


def main() -> None:
    """Draw both."""
    with tempfile.TemporaryDirectory() as folder:
        take_screens(Path(folder))
        for name in NAMES:
            kept = (KEPT / name).with_suffix(".jpg")
            Image.open(Path(folder) / name).convert("RGB").save(kept, quality=QUALITY, optimize=True)
            print(f"{kept}: {kept.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
