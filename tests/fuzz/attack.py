"""Fuzzes one Python reader by atheris: python -m tests.fuzz.attack NAME [options of libFuzzer]."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_file_location
from pathlib import Path
from random import Random
from types import FunctionType, ModuleType

import atheris
from tests.fuzz.laws import Laws
from tests.fuzz.mutate_values import mutated
from tests.fuzz.readers import READERS
from tests.fuzz.seeds import seeds


def import_from_sources() -> None:
    """Import uwsim from its folder, since atheris cannot instrument what an editable install's importer loads."""
    native = find_spec("uwsim._core")
    assert native is not None and native.origin is not None
    origin = native.origin

    class Native:
        @staticmethod
        def find_spec(name: str, *_: object) -> ModuleSpec | None:
            return spec_from_file_location(name, origin) if name == "uwsim._core" else None

    for name in [name for name in sys.modules if name.partition(".")[0] == "uwsim"]:
        del sys.modules[name]
    sys.meta_path[:] = [Native, *(each for each in sys.meta_path if "ScikitBuild" not in type(each).__name__)]
    sys.path.insert(0, str(Path(__file__).parents[2] / "python"))


def instrument_generated() -> None:
    """Instrument the functions that rosbags generates for each type of message when it is first read."""
    from rosbags.serde import cdr

    def compiled(lines: list[str], compile_lines: Callable[[list[str]], ModuleType] = cdr.compile_lines) -> ModuleType:
        module = compile_lines(lines)
        for made in vars(module).values():
            if isinstance(made, FunctionType):
                atheris.instrument_func(made)
        return module

    cdr.compile_lines = compiled


def main() -> None:
    """Instrument the reader while its first inputs are read, then mutate them until the time is over."""
    name, *options = sys.argv[1:]
    import_from_sources()
    os.environ["UWSIM_CACHE"] = ""  # a cache of millions of damaged meshes would be useless
    laws = Laws(name)
    import numpy  # noqa: F401  # not to be instrumented

    if "rosbags" in READERS[name].libraries:
        instrument_generated()
    with atheris.instrument_imports(include=["uwsim", *READERS[name].libraries]):
        for data in seeds(name).values():
            laws.hold(data)

    prefix = next((option.partition("=")[2] for option in options if option.startswith("-artifact_prefix=")), "")

    def hold(data: bytes) -> None:
        try:
            laws.hold(data)
        except Exception:  # atheris ends the process, at times before libFuzzer has written the input
            Path(f"{prefix}crash-{hashlib.sha1(data, usedforsecurity=False).hexdigest()}").write_bytes(data)
            raise

    values = READERS[name].values

    def mutate(data: bytes, longest: int, seed: int) -> bytes:
        """Change values in half of the calls, bytes otherwise."""
        rng = Random(seed)
        changed = mutated(data, values, rng) if values is not None and rng.random() < 0.5 else None
        return atheris.Mutate(data, longest) if changed is None else changed[:longest]

    atheris.Setup([sys.argv[0], *options], hold, **({"custom_mutator": mutate} if values is not None else {}))
    try:
        atheris.Fuzz()
    finally:
        laws.close()


if __name__ == "__main__":
    main()
