"""The command behind `tools/fuzz`."""

from __future__ import annotations

import argparse
import importlib.util
import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

from tests.fuzz import totals
from tests.fuzz.readers import READERS
from tests.fuzz.seeds import seeds

ROOT = Path(__file__).parents[2]
FOUND = ROOT / "tests" / "fuzz" / "found"
NATIVE = ("map", "state", "depth_string")
COMPILER = "clang++-19"
HANG_S, MEMORY_MB = 10, 2048


def main() -> int:
    """Fuzz one reader, or all of them in turn; return 1 if something was found."""
    names = [*READERS, "state"]
    parser = argparse.ArgumentParser(prog="tools/fuzz", description="Fuzz what reads bytes from outside.")
    parser.add_argument(
        "name",
        choices=[*names, "all"],
        metavar="NAME",
        help=f"{', '.join(names)}; or all, in turn",
    )
    parser.add_argument("--seconds", type=int, default=60, help="for each; default 60")
    arguments = parser.parse_args()
    if arguments.seconds < 1:
        parser.error(f"--seconds {arguments.seconds}: must be at least 1")
    chosen = names if arguments.name == "all" else [arguments.name]
    _require_tools(chosen)
    found = [name for name in chosen if not _fuzz(name, arguments.seconds)]
    if found:
        print(f"fuzz: found something in {', '.join(found)}: see build/fuzz/NAME/found")
    return 1 if found else 0


def _require_tools(names: list[str]) -> None:
    if set(names) & set(NATIVE) and shutil.which(COMPILER) is None:
        sys.exit("fuzz: native readers need clang: apt-get install clang-19 libclang-rt-19-dev llvm-19")
    if set(names) - set(NATIVE) and importlib.util.find_spec("atheris") is None:
        sys.exit("fuzz: Python readers need atheris: .venv/bin/pip install -e '.[fuzz]', or pip install atheris")


def _fuzz(name: str, seconds: int) -> bool:
    """Return whether nothing was found. The corpus in build/fuzz/NAME grows with each run."""
    folder = ROOT / "build" / "fuzz" / name
    corpus, found = folder / "corpus", folder / "found"
    for each in (corpus, found):
        each.mkdir(parents=True, exist_ok=True)
    for file, data in seeds(name).items():
        (corpus / file).write_bytes(data)
    known = [str(FOUND / name)] if (FOUND / name).is_dir() else []
    limits = [f"-max_total_time={seconds}", f"-timeout={_hang_s()}", f"-rss_limit_mb={MEMORY_MB}", "-max_len=200000"]
    if name == "state":
        limits.append("-len_control=0")  # its mutator starts with whole states
    options = [*limits, "-print_final_stats=1", f"-artifact_prefix={found}/", str(corpus), *known]
    program = [str(_native(name))] if name in NATIVE else [sys.executable, "-m", "tests.fuzz.attack", name]
    log, before = folder / "log.txt", set(found.iterdir())
    status, run = totals.watch([*program, *options], log, ROOT)
    if status:
        new = set(found.iterdir()) - before
        real = [path for path in new if _is_real(path, name)]
        status = not new or bool(real)
    print(f"fuzz: {name}: {run}", flush=True)
    if status:
        print(f"fuzz: {name}: FOUND; the log: {log}", flush=True)
    return not status


def _is_real(found: Path, name: str) -> bool:
    """Return whether a find repeats; one that was slow or large only under the fuzzer is removed.

    atheris makes instrumented code ten times as slow, and its process grows with each input that has large arrays.
    """
    if not found.name.startswith(("timeout-", "slow-unit-", "oom-")):
        return True
    took_s, memory_mb = _alone(found, name)
    if took_s > HANG_S or memory_mb > MEMORY_MB:
        return True
    print(f"fuzz: {found.name}: takes {took_s:.1f} s and {memory_mb:.0f} MB when it is read alone")
    found.unlink()
    return False


def _alone(found: Path, name: str) -> tuple[float, float]:
    """Return the processor time [s] and memory [MB] needed to read an input; infinite if it fails or never ends."""
    native = [str(_native(name)), f"-rss_limit_mb={MEMORY_MB}"] if name in NATIVE else []
    program = native or [sys.executable, "-m", "tests.fuzz.alone", name]
    limit_s = 100 * HANG_S  # of wall time, on a busy machine
    try:
        again = subprocess.run([*program, str(found)], cwd=ROOT, capture_output=True, text=True, timeout=limit_s)
    except subprocess.TimeoutExpired:
        return math.inf, math.inf
    if again.returncode:
        return math.inf, math.inf
    if not native:
        took_s, memory_mb = again.stdout.split()
        return float(took_s), float(memory_mb)
    executed = re.search(r"^Executed .* in (\d+) ms", again.stderr, re.MULTILINE)
    return (int(executed[1]) / 1000 if executed else math.inf), 0.0


def _hang_s() -> int:
    return math.ceil(HANG_S * totals.slowness())


def _native(name: str) -> Path:
    """Build a native fuzzer; return its path."""
    build = ROOT / "build" / "fuzz" / "native"
    pybind11 = subprocess.check_output([sys.executable, "-m", "pybind11", "--cmakedir"], text=True).strip()
    settings = {
        "CMAKE_CXX_COMPILER": COMPILER,
        "UWSIM_SANITIZE": "address",
        "UWSIM_FUZZERS": "ON",
        "UWSIM_BENCH_PEERS": "OFF",
        "Python_EXECUTABLE": sys.executable,
        "pybind11_DIR": pybind11,
    }
    if shutil.which("ccache"):
        settings["CMAKE_CXX_COMPILER_LAUNCHER"] = "ccache"
    options = [f"-D{key}={value}" for key, value in settings.items()]
    print(f"fuzz: compiling fuzz_{name} (minutes the first time)", flush=True)
    for command in (["-S", ROOT, "-B", build, "-G", "Ninja", *options], ["--build", build, "--target", f"fuzz_{name}"]):
        made = subprocess.run(["cmake", *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if made.returncode:
            sys.exit(f"{made.stdout}\nfuzz: fuzz_{name} could not be compiled")
    return build / "tests" / "fuzz" / "native" / f"fuzz_{name}"


if __name__ == "__main__":
    sys.exit(main())
