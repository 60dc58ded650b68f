"""Threads that catch warnings at the same time leave the process's hook and filters as they were."""

import warnings
from threading import Event, Thread

from uwsim.base.caught_warnings import caught_warnings


def test_overlapping_blocks_of_two_threads_leave_the_hook_and_the_filters() -> None:
    hook, filters = warnings.showwarning, warnings.filters
    inside, second_wants = Event(), Event()

    def first() -> None:
        with caught_warnings():
            inside.set()
            second_wants.wait(180.0)

    def second() -> None:
        inside.wait(180.0)
        second_wants.set()
        with caught_warnings() as issued:
            warnings.warn("mine", UserWarning, stacklevel=1)
            first_thread.join(0.2)
        assert [str(each.message) for each in issued] == ["mine"]

    first_thread, second_thread = Thread(target=first), Thread(target=second)
    first_thread.start(), second_thread.start()
    first_thread.join(), second_thread.join()
    assert warnings.showwarning is hook
    assert warnings.filters is filters
