"""Fuzzes one Python reader by atheris: python -m tests.fuzz.attack NAME [options of libFuzzer]."""

from __future__ import annotations

import os
import sys

import atheris
from tests.fuzz.laws import Laws
from tests.fuzz.readers import READERS
from tests.fuzz.seeds import seeds


def main() -> None:
    """Instrument the reader while its first inputs are read, then mutate them until the time is over."""
    name, *options = sys.argv[1:]
    os.environ["UWSIM_CACHE"] = ""  # a cache of millions of damaged meshes would help nobody
    laws = Laws(name)
    import numpy  # noqa: F401  # not to be instrumented

    with atheris.instrument_imports(include=["uwsim", *READERS[name].libraries]):
        for data in seeds(name).values():
            laws.hold(data)

    atheris.Setup([sys.argv[0], *options], laws.hold)
    try:
        atheris.Fuzz()
    finally:
        laws.close()


if __name__ == "__main__":
    main()
