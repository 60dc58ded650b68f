"""Flies one run again, the same to the last bit, with all that a sweep leaves out: recording, map and report."""

from __future__ import annotations

from pathlib import Path

from uwsim.flight.fly import fly, made_folder
from uwsim.flight.survey import run_survey
from uwsim.flight.terminal import Silent
from uwsim.folder_lock import require_free
from uwsim.scenario.dump import write_scenario
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
        run_survey(
            scenario, folder, voxel_m=job.voxel_m, estimate=job.estimate, autosave_s=0.0, threads=1, report=report,
            record=folder / RECORDING if job.estimate == "truth" else None,  # no other survey can be recorded
            screen=Silent(),
        )  # fmt: skip
        return
    fly(
        job.mission, scenario, folder, arguments=job.arguments, map=job.map, voxel_m=job.voxel_m,
        estimate=job.estimate, time_limit_s=job.time_limit_s, autosave_s=0.0, threads=1, report=report,
        record=folder / RECORDING,
    )  # fmt: skip
