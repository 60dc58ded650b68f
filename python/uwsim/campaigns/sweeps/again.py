"""Repeats one run, bit-identically, and produces everything that a sweep omits: recording, map and report."""

from __future__ import annotations

import logging
from pathlib import Path

from uwsim.base.folder_lock import require_free
from uwsim.campaigns.sweeps.job import Job
from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.scenario.dump import write_scenario

WORST = "worst"
SCENARIO, RECORDING = "scenario.yaml", "run.mcap"

logger = logging.getLogger("uwsim.campaigns")


def fly_run_again(job: Job, folder: Path, report: str = "full") -> None:
    """Repeat a run; write scenario.yaml, run.mcap, map and report to a folder. Raises the same errors as a flight.

    report: see fly.
    """
    made_folder(folder, (SCENARIO, RECORDING))
    require_free(folder)
    scenario = folder / SCENARIO
    if (folder / RECORDING).exists():
        (folder / RECORDING).unlink()
        logger.warning("%s: removed: the recording of an earlier flight", folder / RECORDING)
    write_scenario(scenario, job.varied_scenario())
    is_recordable = job.mission is not None or job.estimate == "truth"  # other surveys cannot be recorded
    fly(
        job.mission, scenario, folder, autosave_s=0.0, threads=1, report=report,
        record=folder / RECORDING if is_recordable else None, **job.flight(),
    )  # fmt: skip
