"""Happening: an event of a recorded run, in words."""

from __future__ import annotations

from typing import NamedTuple

from uwsim.base.commands import NOTE
from uwsim.base.texts.value_words import Detail

ECHOES = {
    "all_stop": ("all_stop", "all_stop_ends"), "inject_fault": ("fault",), "end_fault": ("fault_ends",), NOTE: (NOTE,),
}  # fmt: skip
"""The events of the run that a command causes at once: it is listed in their place."""


class Happening(NamedTuple):
    """An event of a run. kind: `command`, `alarm` (faults and failsafes, too) or `collision`. text: all in English.

    name: of the command or the event. vehicle: "" for the world. details: names and values in words.
    """

    time_s: float
    kind: str
    text: str
    name: str
    vehicle: str = ""
    details: tuple[Detail, ...] = ()
