"""A campaign: numbered jobs that workers do, and whose results a ledger keeps, so that it can be continued."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from functools import partial
from typing import Any

from uwsim.campaigns.workers.ledger import Ledger
from uwsim.campaigns.workers.options import CampaignOptions
from uwsim.campaigns.workers.work import Finished, Show, Tell, Work
from uwsim.campaigns.workers.workers import Workers, open_workers

RETRIES = 2


class Campaign:
    """A campaign's options, and what shows its progress.

    kind: the class of its options. stop_requested: ends the campaign early, once it is true. tell, show: see work.py.
    options: by name. wall_s: time for which the workers have worked. Raises OptionError.
    """

    def __init__(
        self,
        kind: type[CampaignOptions] = CampaignOptions,
        stop_requested: Callable[[], bool] = lambda: False,
        tell: Tell = lambda finished, failed, count: None,
        show: Show = lambda activity: nullcontext(),
        **options: Any,
    ) -> None:
        self.options = kind(**options)
        self.stop_requested, self.tell, self.show = stop_requested, tell, show
        self.wall_s = 0.0

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> tuple[Campaign, dict[str, Any]]:
        """Return the campaign with those of some options that are a campaign's, and the others."""
        own = inspect.signature(cls).parameters.keys() | CampaignOptions.flags().keys()
        campaign = cls(**{name: value for name, value in options.items() if name in own})
        return campaign, {name: value for name, value in options.items() if name not in own}

    @property
    def job_threads(self) -> int | None:
        """The number of threads for each job: one, unless all run in this process."""
        return None if self.options.workers == 0 else 1

    def crew(self) -> Workers:
        """Return the workers, for use in a `with` statement. Raises ValueError or OSError."""
        with self.show("starting workers"):
            return open_workers(self.options.workers, scheduler=self.options.scheduler)

    def run(
        self, ledger: Ledger, work: Work, jobs: Mapping[int, Any], *, retries: int = RETRIES,
        result_of: Callable[[Finished], Mapping[str, Any]] | None = None,
        lacks: Callable[[int], bool] = lambda number: False,
        then: Callable[[int, Mapping[str, Any]], object] = lambda number, result: None,
    ) -> int:  # fmt: skip
        """Run those jobs that the ledger lacks, and record each as it finishes; return how many were run.

        result_of: returns what the ledger keeps; by default the job's result, and a job without one ends the campaign
        with OSError. lacks: whether a finished job is missing nevertheless. then: called with each number and result,
        once it is recorded.
        """
        is_missing = partial(ledger.lacks, retry_failed=getattr(self.options, "retry_failed", False))
        missing = {number: job for number, job in jobs.items() if is_missing(number) or lacks(number)}
        if not missing:
            return 0
        begun = finished = len(jobs) - len(missing)
        failed = sum(bool(result.get("error")) for number, result in ledger.results.items() if number not in missing)
        with self.crew() as crew:
            begun_s = time.perf_counter()
            self.tell(finished, failed, len(jobs))
            for each in crew.finished(work, missing, retries=retries, stop_requested=self.stop_requested):
                result = (result_of or ledger.result_of)(each)
                ledger.add(each.job, result)
                finished, failed = finished + 1, failed + bool(result.get("error"))
                self.tell(finished, failed, len(jobs))
                then(each.job, result)
            self.wall_s = time.perf_counter() - begun_s
        return finished - begun
