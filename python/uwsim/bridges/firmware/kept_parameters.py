"""Parameters that a firmware has kept from an earlier start, where the simulation needs others."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

REAL32, REBOOT = 9, 246  # MAV_PARAM_TYPE, MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
ROUNDS = 10
"""Seconds in which the firmware is asked; it does not answer for parameters that its version does not have."""
SETTLED = 2
"""Seconds between the last change and the restart, in which it is stored."""

logger = logging.getLogger("uwsim.bridges.ardusub")


class KeptParameters:
    """Reads what a firmware has kept, sets what differs, and then lets it start again.

    Kept values take precedence over files of defaults, and a firmware reads some only when it starts. needed: values by
    name. mav: encodes messages; send: sends one to the firmware, which has this MAVLink system id.
    """

    def __init__(self, needed: Mapping[str, float], mav: Any, system: int, send: Callable[[Any], None]) -> None:
        self._needed, self._mav, self._system, self._send = needed, mav, system, send
        self._unread, self._wrong = set(needed), set[str]()
        self._changed: list[str] = []
        self._left, self._settling = ROUNDS, SETTLED

    @property
    def is_done(self) -> bool:
        """True if nothing remains to be done."""
        return not self._left

    def note(self, message: Any) -> None:
        """Take a message of the firmware."""
        name = message.param_id if message.get_type() == "PARAM_VALUE" else ""
        if name in self._needed:
            self._unread.discard(name)
            self._wrong.discard(name)
            if not math.isclose(message.param_value, np.float32(self._needed[name]), rel_tol=1e-5, abs_tol=1e-6):
                self._wrong.add(name)

    def act(self) -> None:
        """Do what is due; called every simulated second until done."""
        if self._left and (self._wrong or (self._unread and self._left > 1)):
            self._left, self._settling = max(self._left - 1, 1), SETTLED
            for name in sorted(self._unread):
                self._send(self._mav.param_request_read_encode(self._system, 1, name.encode(), -1))
            for name in sorted(self._wrong):
                self._send(self._mav.param_set_encode(self._system, 1, name.encode(), self._needed[name], REAL32))
            self._changed += sorted(self._wrong - set(self._changed))
        elif self._left and self._changed and self._settling:
            self._settling -= 1
        elif self._left:
            self._left = 0
            if self._changed:
                what = ", ".join(f"{name} = {self._needed[name]:g}" for name in self._changed)
                logger.warning("ArduSub had kept other values: starts again with %s", what)
                self._send(self._mav.command_long_encode(self._system, 1, REBOOT, 0, 1, 0, 0, 0, 0, 0, 0))
