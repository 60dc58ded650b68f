"""The totals of a fuzzer's run."""

from __future__ import annotations

import re
import resource
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

COVERED = re.compile(r"^#(\d+)\s+(\w+)\s+cov: (\d+)")
EXECUTED = re.compile(r"^stat::number_of_executed_units:\s+(\d+)")
INTERRUPTED = 72
"""libFuzzer's exit code when it is interrupted."""
MEMORY = re.compile(r"^stat::peak_rss_mb:\s+(\d+)")


@dataclass
class Total:
    """One run's totals. seconds: wall time; processor_s: its share of it; idle_s: since the last new edge."""

    seconds: float = 0
    processor_s: float = 0
    inputs: int = 0
    edges: int = 0
    idle_s: float = 0
    memory_mb: int = 0

    def __str__(self) -> str:
        new = f"nothing new for {self.idle_s:.0f} s" if self.idle_s >= 1 else "still finding new edges"
        return (
            f"{self.inputs} inputs in {self.seconds:.0f} s ({self.processor_s:.0f} s of a processor), "
            f"{self.edges} edges, {new}, {self.memory_mb} MB at most"
        )


def slowness() -> float:
    """Return the slowdown against a quiet machine, since libFuzzer's limits are in wall time."""
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    while time.process_time() - cpu_s < 0.3:
        pass
    return max((time.perf_counter() - wall_s) / 0.3, 1.0)


def watch(command: list[str], log: Path, folder: Path) -> tuple[int, Total]:
    """Run a fuzzer in `folder`, with its output in `log`; return its exit code, 0 if interrupted, and its totals."""
    run = Total()
    began_s, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    last_new_s, begun = began_s, False
    with (
        log.open("w") as kept,
        subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        ) as fuzzer,
    ):
        assert fuzzer.stdout is not None
        signal.signal(signal.SIGTERM, lambda *_: fuzzer.terminate())  # it prints its totals, which are kept
        for line in fuzzer.stdout:
            kept.write(line)
            if covered := COVERED.match(line):
                run.inputs = int(covered[1])
                if begun and int(covered[3]) > run.edges:
                    last_new_s = time.monotonic()
                run.edges = max(run.edges, int(covered[3]))
                begun = begun or covered[2] == "INITED"  # edges reached before then were found by earlier runs
            elif executed := EXECUTED.match(line):
                run.inputs = int(executed[1])
            elif memory := MEMORY.match(line):
                run.memory_mb = int(memory[1])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    run.seconds = time.monotonic() - began_s
    run.idle_s = began_s + run.seconds - last_new_s
    run.processor_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return 0 if fuzzer.returncode in (INTERRUPTED, -signal.SIGTERM) else fuzzer.returncode, run
