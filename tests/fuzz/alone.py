"""Reads one input without what a fuzzer adds: python -m tests.fuzz.alone NAME PATH; prints processor seconds and MB."""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

from tests.fuzz.laws import Laws


def main() -> None:
    """Hold the reader to its laws, after an input that lets it import what it needs."""
    name, path = sys.argv[1:]
    laws = Laws(name)
    try:
        laws.hold(b"")
        before_s = time.process_time()
        laws.hold(Path(path).read_bytes())
        memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        sys.stdout.write(f"{time.process_time() - before_s} {memory_mb}\n")
    finally:
        laws.close()


if __name__ == "__main__":
    main()
