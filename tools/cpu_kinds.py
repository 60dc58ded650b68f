"""Compare the results of different kinds of CPU. `python tools/cpu_kinds.py` prints a table for docs/inside/trust.md.

One machine emulates the others: UWSIM_INSTRUCTION_SET selects the instructions of the kernels and Embree,
and GLIBC_TUNABLES those of the C library, as on a machine that lacks all others.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

NO_FMA = "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX512F_Usable,-AVX2,-FMA,-FMA4,-AVX512F"
KINDS = {
    "kernels and Embree: AVX2": {"UWSIM_INSTRUCTION_SET": "avx2"},
    "kernels and Embree: SSE2": {"UWSIM_INSTRUCTION_SET": "portable"},
    "C library without FMA and AVX2": {"GLIBC_TUNABLES": NO_FMA},
    "all of these": {"UWSIM_INSTRUCTION_SET": "portable", "GLIBC_TUNABLES": NO_FMA},
}
SCENARIOS, SEEDS = ("cove", "lagoon", "lake", "pool", "reservoir"), range(201, 221)
"""The pictures of all cameras at the start, besides those of the flights."""
FLY = """
import sys
import numpy as np
from tools.cpu_kinds import all_results
np.savez(sys.argv[1], *[array for _, array in all_results()])
"""


def main() -> None:
    """Print the differences from this machine's default: the number of array elements and the largest gap."""
    names = [name for name, _ in all_results()]
    with tempfile.TemporaryDirectory() as folder:
        here = _flown(Path(folder) / "here.npz", {})
        for kind, variables in KINDS.items():
            found = _flown(Path(folder) / "there.npz", variables)
            for part in dict.fromkeys(names):
                pairs = [(a, b) for name, a, b in zip(names, here, found, strict=True) if name == part]
                if any(a.tobytes() != b.tobytes() for a, b in pairs):
                    print(f"| {kind} | {part} | {_gap(pairs)} |")
    pictures = sum(name.startswith("pictures at") for name in names)
    print(f"{pictures} pictures at the start of {len(SCENARIOS)} scenarios, {len(SEEDS)} seeds")


def all_results() -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of the fingerprint's flights, then pictures, each with the name of its part."""
    from uwsim import Simulator
    from uwsim.evidence.fingerprint import results

    yield from results()
    for scenario in SCENARIOS:
        with Simulator(scenario) as sim:
            for seed in SEEDS:
                sim.reset(seed=seed)
                for vehicle in sim.vehicles.values():
                    for camera in vehicle.cameras.values():
                        yield f"pictures at the start of {scenario}", camera.capture().rgb


def _flown(path: Path, variables: dict[str, str]) -> list[np.ndarray]:
    subprocess.run([sys.executable, "-c", FLY, str(path)], env=os.environ | variables, check=True)
    with np.load(path) as arrays:
        return [arrays[f"arr_{k}"] for k in range(len(arrays.files))]


def _gap(pairs: list[tuple[np.ndarray, np.ndarray]]) -> str:
    unlike = sum(int(np.sum(~((a == b) | ((a != a) & (b != b))))) for a, b in pairs if a.shape == b.shape)
    total = sum(a.size for a, _ in pairs)
    np.seterr(invalid="ignore")  # a beam without an echo is infinite in both
    gaps = [np.abs(a.astype(float) - b.astype(float)) for a, b in pairs if a.shape == b.shape]
    largest = max((float(np.nanmax(g[np.isfinite(g)], initial=0.0)) for g in gaps), default=0.0)
    came_or_went = sum(int(np.sum(np.isfinite(a.astype(float)) != np.isfinite(b.astype(float)))) for a, b in pairs)
    return f"{unlike} of {total:,} numbers, by {largest:.2g} at most; {came_or_went} echoes came or went"


if __name__ == "__main__":
    main()
