"""Repeats one run, bit-identically, and produces everything that a sweep omits: recording, map and report."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.base.folder_lock import require_free
from uwsim.base.own_files import remove_own_file
from uwsim.campaigns.sweeps.job import Job, flat, run_values
from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.scenario.dump import write_scenario

WORST = "worst"
SCENARIO, RECORDING = "scenario.yaml", "run.mcap"

logger = logging.getLogger("uwsim.campaigns")


def fly_run_again(job: Job, folder: Path, expected: Mapping[str, Any], report: str = "full") -> list[str]:
    """Repeat a run; write scenario.yaml, run.mcap, map and report to a folder. Raises the same errors as a flight.

    expected: the values of the run as the sweep flew it, without a recording. report: see fly. Return a sentence for
    each value that differs, of which there are none with the same build.
    """
    made_folder(folder, (SCENARIO, RECORDING))
    require_free(folder)
    scenario = folder / SCENARIO
    if (folder / RECORDING).exists():
        remove_own_file(folder / RECORDING)
        logger.warning("%s: removed: the recording of an earlier flight", folder / RECORDING)
    write_scenario(scenario, job.varied_scenario())
    is_recordable = job.mission is not None or job.estimate == "truth"  # other surveys cannot be recorded
    flown = fly(
        job.mission, scenario, folder, autosave_s=0.0, threads=1, report=report,
        record=folder / RECORDING if is_recordable else None, **job.flight(),
    )  # fmt: skip
    again = flat(run_values(flown))
    return [
        f"{name} = {again[name]!r}, but {expected[name]!r} in the sweep"
        for name in sorted(expected.keys() & again.keys())
        if again[name] is not None and again[name] != expected[name]
    ]
