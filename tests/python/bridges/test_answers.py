"""Each call of a service is answered exactly once, also one that arrives while the server stops."""

import logging
import threading

from uwsim.bridges.answers import Lane


def test_every_call_is_answered_before_during_and_after_the_end() -> None:
    lane, answers, goes_on = Lane("lane", 1, logging.getLogger(), most=3), [], threading.Event()
    answered = threading.Semaphore(0)

    def answer(succeeded: bool, values: object) -> None:
        answers.append((succeeded, values))
        answered.release()

    lane.submit(lambda: goes_on.wait() and "done", answer)
    lane.submit(lambda: "queued", answer)
    lane.close()
    for _ in range(5):  # more than may wait: those that failed do not
        lane.submit(lambda: "late", answer)
    goes_on.set()
    for _ in range(7):
        answered.acquire()
    assert sorted(answers, key=str) == [*[(False, "the server stops")] * 6, (True, "done")]
