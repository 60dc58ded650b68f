"""Attack one process for ten minutes with all that it serves at once, and kill others' jobs meanwhile.

    .venv/bin/python tools/soak [--minutes 10] [--seed 0] [--json FILE]

A station's page is flown in a browser; hostile and ordinary clients (clients.py) crowd its rosbridge; eight threads
make random calls on shared objects and their own (calls.py); surveys, missions, sweeps and fleets are killed (kill.py).

The rules: only documented errors, and no crash; no lost step; a thread's work on its own objects gives the same bytes
as alone; a resumed job gives those of an uninterrupted one; after the first fifth of the time, in which they settle, a
straight line through samples of memory grows by at most MEMORY_MB, one through those of the page's heap by HEAP_MB, and
files and threads of the process do not rise; nothing of a client is left when it has gone. A map, a track and logs
grow because vehicles fly. Exits with 1 if a rule is broken.
"""

from __future__ import annotations

import faulthandler
import json
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from calls import Shared, Worker, programs

sys.path.append(str(Path(__file__).parents[1] / "bench"))
from _harness import child, ended, station_page, trimmed_mb

MEMORY_MB, HEAP_MB, SETTLING = 16.0, 8.0, 0.2
ASTERN_S, TURN_S, AHEAD_S = 3.0, 5.0, 12.0
LEFT_S = 10.0  # until the last client's connection has been noticed to be closed
HERE = Path(__file__).parent


def main(
    minutes: Annotated[float, typer.Option(min=3.0, help="How long everything runs [min].")] = 10.0,
    threads: Annotated[int, typer.Option(min=1, help="Number of threads.")] = 8,
    seed: Annotated[int, typer.Option(help="The seed of calls and kills.")] = 0,
    out: Annotated[Path | None, typer.Option("--json", help="Also write the samples to this file.")] = None,
) -> None:
    """Attack, sample and judge."""
    faulthandler.enable()
    sys.setswitchinterval(0.0001)  # more often than the default, to provoke more errors
    with tempfile.TemporaryDirectory() as folder:
        own = programs(Path(folder))
        alone = {name: program() for name, program in own.items()}
        kills = child(str(HERE / "kill.py"), "--minutes", minutes, "--seed", seed)
        with ExitStack() as stack:
            server, station, page, _ = stack.enter_context(station_page("lake"))
            topics = len(server.graph.topics)
            clients = child(str(HERE / "clients.py"), server.url, 60.0 * minutes + 3600.0)
            stack.callback(ended, clients)
            assert clients.stdout is not None
            clients.stdout.readline()  # the largest number of clients has come and gone: the allocator keeps its memory
            shared = Shared(Path(folder))
            gate = threading.Event()
            workers = [Worker(shared, own, alone, seed + number, gate) for number in range(threads)]
            with calling(workers, gate):
                samples = list(flown(page, station, workers, gate, minutes))
            ticks = shared.stopped()
            gone = clients.poll() is not None
            ended(clients)
            time.sleep(LEFT_S)
            left = len(server.sessions) - 1, max(0, len(server.graph.topics) - topics)  # the page's own session
            served = station.present().live.error
    typer.echo(kills.communicate()[0])
    if out is not None:
        out.write_text(json.dumps(samples, indent=1) + "\n", encoding="utf-8")
    called = sum((worker.called for worker in workers), Counter())
    stepped = sum((worker.stepped for worker in workers), Counter())
    typer.echo(f"{called.total()} calls: {dict(sorted(called.items()))}\nsteps {dict(stepped)}, came to {ticks}")
    errors = [error for worker in workers for error in worker.errors]
    for kind, count in Counter(errors).most_common(10):
        typer.echo(f"{count} times {kind}")
    grown = {
        name: growth([sample[name] for sample in samples]) for name in ("memory_mb", "heap_mb", "files", "threads")
    }
    typer.echo("grown: " + ", ".join(f"{name} {by:+.1f} +- {error:.1f}" for name, (by, error) in grown.items()))
    memory_mb, heap_mb, files, thread_count = (by - 2.0 * error for by, error in grown.values())  # at least
    rules = {
        f"{len(errors)} errors": not errors,
        "steps": ticks == {name: stepped[name] for name in ticks},
        "memory": memory_mb <= MEMORY_MB,
        "heap of the page": heap_mb <= HEAP_MB,
        "open files": files < 1.0,
        "threads": thread_count < 1.0,
        "clients": not gone,
        f"left of clients: {left[0]} sessions, {left[1]} topics": left == (0, 0),
        f"the served simulator: {served}": served is None,
        f"left files: {shared.left}": not shared.left,
        "kills": kills.returncode == 0,
    }
    wrong = [name for name, is_kept in rules.items() if not is_kept]
    typer.echo(f"wrong: {', '.join(wrong) or 'nothing'}")
    raise typer.Exit(bool(wrong))


@contextmanager
def calling(workers: Sequence[Worker], gate: threading.Event) -> Iterator[None]:
    """Run the threads until the end of the context."""
    for worker in workers:
        worker.start()
    gate.set()
    try:
        yield
    finally:
        for worker in workers:
            worker.ends = True
        gate.set()
        for worker in workers:
            worker.join()


def flown(
    page: Any, station: Any, workers: Sequence[Worker], gate: threading.Event, minutes: float
) -> Iterator[dict[str, float]]:
    """Drive astern, turn and go ahead until the time is over; yield a sample of each turn."""
    session = page.context.new_cdp_session(page)
    ends_s = time.monotonic() + 60.0 * minutes
    while time.monotonic() < ends_s:
        for key, seconds in (("s", ASTERN_S), ("e", TURN_S), ("w", AHEAD_S)):  # astern: away from what it has hit
            page.keyboard.press(key, delay=1e3 * seconds)
        session.send("HeapProfiler.collectGarbage")
        gate.clear()
        with ExitStack() as held:  # while no thread is inside a call, so that objects of calls are not counted
            for worker in workers:
                held.enter_context(worker.busy)
            sample = {
                "memory_mb": trimmed_mb(),
                "objects": sys.getallocatedblocks(),
                "heap_mb": 1e-6 * session.send("Runtime.getHeapUsage")["usedSize"],
                "threads": len(list(Path("/proc/self/task").iterdir())),
                "files": open_files(),
                "pace": station.present().live.factor,
            }
        gate.set()
        typer.echo("  ".join(f"{name} {value:.5g}" for name, value in sample.items()))
        yield sample


def open_files() -> int:
    """Return the number of open files except sockets, since the number of clients does not depend on this process."""
    count = 0
    for link in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # it has been closed in the meantime
            count += not str(link.readlink()).startswith("socket:")
    return count


def growth(samples: Sequence[float]) -> tuple[float, float]:
    """Return the growth of a straight line through the samples, without those in which values settle, and its error."""
    kept = np.array(samples[int(SETTLING * len(samples)) :])
    line, variances = np.polyfit(np.arange(len(kept)), kept, 1, cov=True)
    return float(line[0] * (len(kept) - 1)), float(np.sqrt(variances[0, 0]) * (len(kept) - 1))


if __name__ == "__main__":
    typer.run(main)
