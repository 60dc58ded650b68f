"""Workers that run jobs in this process as others would run them."""

import pickle
from collections.abc import Callable
from dataclasses import replace

from uwsim.campaigns.workers import Finished
from uwsim.campaigns.workers.workers import ThisProcess


class Elsewhere(ThisProcess):
    """Runs jobs as copies, the last first, on two threads, without what this process has built, which it forgets."""

    def __init__(self, forget: Callable[[], None]) -> None:
        self.forget = forget

    def finished(self, work, jobs, *, retries, stop_requested):
        for number in reversed(list(jobs)):
            self.forget()
            yield Finished(number, work(pickle.loads(pickle.dumps(replace(jobs[number], threads=2)))))
