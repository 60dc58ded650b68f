"""The processor seconds of tests by room, which `python -m tools.budget` compares with its numbers."""

import json
import os
import time
from collections import Counter
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

WRITTEN = Path(__file__).parents[2] / "build/test_seconds.json"
WHOLE_TESTS = 5000  # fewer are a choice, whose seconds state nothing of the others


class ProcessorSeconds:
    """Sums what each test and its fixtures use, ended children included; the first process writes the sums of all."""

    def __init__(self) -> None:
        self.rooms: Counter[str] = Counter()
        self.tests = 0
        self.loops_s: list[float] = []

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Measure a test."""
        before_s = _used_s()
        try:
            return (yield)
        finally:
            self.rooms[Path(item.location[0]).parent.name] += _used_s() - before_s
            self.tests += 1
            if self.tests % 100 == 1:
                self.loops_s.append(_loop_s())

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Pass the sums to the first process, or write them there."""
        if (output := getattr(session.config, "workeroutput", None)) is not None:
            output["processor_seconds"] = (dict(self.rooms), self.tests, self.loops_s)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Add what another process measured."""
        rooms, tests, loops_s = getattr(node, "workeroutput", {}).get("processor_seconds", ({}, 0, []))
        self.rooms += Counter(rooms)
        self.tests += tests
        self.loops_s += loops_s

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Write the sums of a whole run, and report their total."""
        if self.tests < WHOLE_TESTS:
            return
        rooms = {name: round(seconds, 1) for name, seconds in sorted(self.rooms.items())}
        loop_s = sorted(self.loops_s)[len(self.loops_s) // 2]
        WRITTEN.write_text(json.dumps({"loop_s": round(loop_s, 4), "rooms": rooms}, indent=1) + "\n")
        used = f"{sum(rooms.values()):.0f} s of a processor, of which a fixed loop takes {loop_s:.4f} s"
        terminalreporter.write_line(f"{self.tests} tests used {used} ({WRITTEN.name})")


def _used_s() -> float:
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def _loop_s() -> float:
    before_s = time.process_time()
    sum(number * number for number in range(200_000))
    return time.process_time() - before_s
