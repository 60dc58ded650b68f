"""Wall-clock time per stage."""

import time

import pytest

from uwsim.base.wall_timer import WallTimer


def test_each_second_counts_once_for_the_innermost_block(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now_s[0])
    timer = WallTimer(("outer", "inner", "never"))

    def pass_time(seconds: float) -> None:
        now_s[0] += seconds

    inner = timer.timed("inner", pass_time)
    with timer.measure("outer"):
        pass_time(1.0)
        inner(2.0)
        with timer.measure("third"):
            inner(4.0)
            pass_time(8.0)
        pass_time(16.0)
    assert timer.wall_s == {"outer": 17.0, "inner": 6.0, "third": 8.0, "never": 0.0}
