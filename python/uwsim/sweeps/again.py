"""Flies one run again, the same to the last bit, with all that a sweep leaves out: recording, map and report."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

from ruamel.yaml import YAML

from uwsim.atomic_file import write_atomically
from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.folder_lock import require_free
from uwsim.scenario import Scenario
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


def write_scenario(path: Path, scenario: Scenario) -> None:
    """Write a scenario as a YAML file that stands by itself, apart from meshes and rasters. Raises OSError."""
    text = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.dump(scenario.model_dump(mode="json", exclude_none=True), text)
    write_atomically(path, text.getvalue().encode())
