"""The score sheet as lines of text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def score_lines(sheet: Mapping[str, Any]) -> list[str]:
    """Return the score of a course's sheet as lines."""
    lines = [f"{goal['scored']:6.1f} of {goal['points']:g}  {goal['title']}" for goal in sheet["goals"]]
    lines += [
        f"{-each['cost']:6.1f}       {each['title']}, broken at {each['time_s']:.1f} s" for each in sheet["broken"]
    ]
    lines += [
        f"{-aid['cost']:6.1f}       {aid['kind']}, used for {aid['used_s']:.1f} s"
        for aid in sheet["aids"]
        if aid["used_s"]
    ]
    verdict = "passed" if sheet["has_passed"] else f"not passed, which takes {sheet['pass_points']:g}"
    if not sheet["is_valid"]:
        verdict = f"not valid: {sheet['invalid_because']}"
    return [*lines, f"{sheet['score']:6.1f} of {sheet['points']:g}  {verdict}; {sheet['ended_because']}"]


def sheet_lines(sheet: Mapping[str, Any]) -> list[str]:
    """Return a certified sheet as lines: who, when and where, the score, the limits, and what happened."""
    head = {
        "person": sheet["person"] or "not named", "date": sheet["date"], "scenario": sheet["scenario"],
        "seed": sheet["seed"], "attempt": sheet["attempt"], "duration": f"{sheet['time_s']:.1f} s",
        "uwsim": f"{sheet['uwsim']}, build {sheet['build']}",
    }  # fmt: skip
    limits = [
        f"{-limit['cost']:6.1f} each  {limit['title']}: broken {limit['broken']} times" for limit in sheet["limits"]
    ]
    happened = [(each["time_s"], f"{each['kind']}: {each['text']}") for each in sheet["log"]]
    happened += [(act["time_s"], f"command: {act['text']}") for act in sheet["acts"]]
    happened += [(act["time_s"], f"{act['by']}: {act['text']}") for act in sheet["outside_acts"]]
    if omitted := sheet["acts_omitted"] + sheet["outside_acts_omitted"]:
        happened.append((sheet["time_s"], f"{omitted} more acts are not listed"))
    return [
        sheet["title"], *(f"{key:<9} {value}" for key, value in head.items()), "", *score_lines(sheet), "",
        *limits, "", *(f"{time_s:8.1f} s  {text}" for time_s, text in sorted(happened, key=lambda each: each[0])),
        "", f"digest    {sheet['digest']} (no signature: it shows only that the file is as it was written)",
    ]  # fmt: skip
