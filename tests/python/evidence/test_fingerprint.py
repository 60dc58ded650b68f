"""The same input gives the same output whatever the threads, processor, locale, time zone, hash seed and addresses."""

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.fuzz.laws import Laws
from tests.fuzz.readers import READERS
from tests.fuzz.seeds import seeds

from command_line import error_line, uwsim, uwsim_process
from uwsim.evidence import fingerprint as module
from uwsim.evidence.fingerprint import Fingerprint, fingerprint

PINGS = 6  # two pictures of each camera
ELSEWHERE = """
import json, locale, sys
locale.setlocale(locale.LC_ALL, "")
assert locale.localeconv()["decimal_point"] == ",", locale.localeconv()
from test_fingerprint import read_all
from uwsim.evidence import fingerprint as module
module.PINGS = int(sys.argv[2])
print(json.dumps([module.fingerprint("pool", seed=7, threads=int(sys.argv[1])).parts, read_all()]))
"""


def read_all() -> dict[str, str]:
    """Return a digest of each reader's result for every fourth of the initial files of its fuzzer."""
    digests = {}
    for name in sorted(READERS.keys() - {"mcap"}):
        laws = Laws(name)
        try:
            read = [repr(laws.hold(data).content) for _, data in sorted(seeds(name).items())[::4]]
        finally:
            laws.close()
        said = "".join(read).replace(str(laws.folder), "")
        digests[name] = hashlib.blake2b(said.encode(), digest_size=8).hexdigest()
    return digests


@pytest.fixture(autouse=True, scope="module")
def short() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "PINGS", PINGS)
        yield


@pytest.fixture(scope="module")
def seven() -> Fingerprint:
    return fingerprint("pool", seed=7, threads=1)


@pytest.fixture(scope="module")
def german(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment for a locale with a decimal comma."""
    folder = tmp_path_factory.mktemp("locales")
    subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"], check=True)
    return {"LOCPATH": str(folder), "LC_ALL": "de_DE.UTF-8"}


def test_the_same_in_another_process_elsewhere(german: dict[str, str], seven: Fingerprint) -> None:
    """The other process differs in addresses, processors, threads, hash seed, time zone and locale."""
    prefix, threads = ["setarch", "-R", "taskset", "--cpu-list", "0"], 3
    places = [str(Path(__file__).parents[k]) for k in (0, 1, 3)]
    other = {"TZ": "Pacific/Chatham", "PYTHONHASHSEED": str(threads), "UWSIM_CACHE": "", **german}
    env = os.environ | other | {"PYTHONPATH": os.pathsep.join(places)}
    ran = subprocess.run(
        [*prefix, sys.executable, "-c", ELSEWHERE, str(threads), str(PINGS)],
        env=env, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout) == [seven.parts, read_all()]


def test_a_seed_changes_what_is_random_and_the_command_prints_what_the_function_returns(
    seven: Fingerprint, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, other = seven, fingerprint("pool", seed=8, threads=1)
    different = {part for part in first.parts if first.parts[part] != other.parts[part]}
    assert {"samples", "samples in rough water", "poses in rough water", "ranges in rough water"} <= different
    assert first.whole != other.whole
    assert {"poses", "samples", "ranges", "pictures", "map"} <= first.parts.keys()
    calls = []
    monkeypatch.setattr(
        "uwsim.evidence.fingerprint.fingerprint", lambda *given, **options: calls.append((given, options)) or seven
    )
    printed = json.loads(uwsim("scenario", "fingerprint", "pool", "--seed", "7", "--json").stdout)
    assert printed == {
        "scenario": "pool",
        "seed": 7,
        "whole": first.whole,
        "parts": first.parts,
        "machine": first.machine,
    }
    assert [(*given, options["seed"]) for given, options in calls] == [("pool", 7)]
    assert uwsim("scenario", "fingerprint", "pool", "--seed", "7").stdout.splitlines()[-1].split() == [
        "all",
        first.whole,
    ]


def test_an_instruction_set_that_there_is_not_is_refused() -> None:
    failed = uwsim_process("scenario", "fingerprint", "pool", env=os.environ | {"UWSIM_INSTRUCTION_SET": "mmx"})
    assert failed.returncode == 1
    assert "UWSIM_INSTRUCTION_SET = mmx: must be portable, avx2 or avx512" in error_line(failed)
    assert "UWSIM_INSTRUCTION_SET = AVX2: must be portable" in chosen("AVX2").stderr


def test_the_narrowest_instruction_set_is_one_that_every_machine_can_choose() -> None:
    assert chosen("portable").stdout == "portable\n"


def chosen(name: str) -> subprocess.CompletedProcess[str]:
    program = "from uwsim import _core; print(_core.instruction_set())"
    env = os.environ | {"UWSIM_INSTRUCTION_SET": name}
    return subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, text=True, check=False)
