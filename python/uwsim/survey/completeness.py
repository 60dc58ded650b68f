"""Whether a survey covered enough of its area."""

from __future__ import annotations

import math

from uwsim.survey.record import SurveyRecord

ENOUGH_PERCENT = 95.0
"""Coverage from which a survey that ended early counts as complete."""


def coverage_shortfall(record: SurveyRecord, min_coverage_percent: float | None = None) -> str | None:
    """Return a sentence if the survey's coverage is below the minimum, else None.

    min_coverage_percent: by default ENOUGH_PERCENT for a survey that ended early, such as by an empty battery, and no
    minimum for one that flew all its lanes.
    """
    least = min_coverage_percent
    if least is None:
        least = ENOUGH_PERCENT if record.ended_early else 0.0
    coverage = 100.0 * (record.coverage or 0.0)
    if coverage >= least:
        return None
    if record.coverage is None:
        return f"the survey is incomplete: its coverage is unknown, since the map was not scored; {_why(record)}"
    shown = math.floor(10.0 * coverage) / 10.0  # rounded down, so that it never seems to reach the minimum
    return f"the survey is incomplete: coverage is {shown:.1f} %, must be at least {least:g} %; {_why(record)}"


def _why(record: SurveyRecord) -> str:
    return f"it ended early: {record.stopped_because}" if record.ended_early else "all lanes were flown"
