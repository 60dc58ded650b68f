"""Flies one run again, the same to the last bit, with all that a sweep leaves out: recording, map and report."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.folder_lock import require_free
from uwsim.scenario.dump import write_scenario
from uwsim.survey.run import run_survey
from uwsim.sweeps.job import Job

WORST = "worst"
SCENARIO, RECORDING = "scenario.yaml", "run.mcap"


def fly_run_again(job: Job, folder: Path, report: str = "full") -> None:
    """Write scenario.yaml, run.mcap, map and report of a run into a folder. Raises what a flight does.

    report: see run_survey.
    """
    made_folder(folder)
    require_free(folder)
    (folder / RECORDING).unlink(missing_ok=True)
    scenario = folder / SCENARIO
    write_scenario(scenario, job.varied_scenario())
    if job.mission is None:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            run_survey(
                scenario, folder, voxel_m=job.voxel_m, estimate=job.estimate, autosave_s=0.0, threads=1, report=report,
                record=folder / RECORDING if job.estimate == "truth" else None,  # no other survey can be recorded
            )  # fmt: skip
        return
    fly(
        job.mission, scenario, folder, arguments=job.arguments, map=job.map, voxel_m=job.voxel_m,
        estimate=job.estimate, time_limit_s=job.time_limit_s, autosave_s=0.0, threads=1, report=report,
        record=folder / RECORDING,
    )  # fmt: skip
