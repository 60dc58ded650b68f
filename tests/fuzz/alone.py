"""Reads one input without a fuzzer: python -m tests.fuzz.alone NAME PATH; prints processor seconds and MB."""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

from tests.fuzz.laws import Laws


def main() -> None:
    """Check the reader's laws, after a first input that makes it import its modules."""
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
