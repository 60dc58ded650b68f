"""The policy on who may command a vehicle while a pilot at the operator's station has the controls.

- All stop may be set by any client at any time.
- While a pilot has the controls, all other commands of other clients to a vehicle are refused, on every bridge: its
  command topics (/key, /cmd_vel, ...), its command services (/release, /dock, ...), its lamps, and the release of all
  stop. Any command in effect when the pilot takes the controls ends at that moment.
- Services of the simulation stay open, since they do not drive: pace, parameters, pictures, maps.
- Without a pilot, the last command takes effect. The station shows who issued it, and no page takes the controls
  automatically.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from uwsim.base.commands import ALL_STOP


class Rights:
    """The right to command the vehicles of one simulator. pilot: returns the name of the station's pilot, or ""."""

    def __init__(self) -> None:
        self.pilot: Callable[[], str] = lambda: ""

    def require(self, name: str, request: Mapping[str, Any] | None = None) -> None:
        """Raise ValueError unless a client may currently use a command's topic or service with this request."""
        stops = name.rpartition("/")[2] == ALL_STOP and (request or {}).get("data") is not False
        pilot = "" if stops else self.pilot()
        if pilot:
            raise ValueError(f"/{name}: refused: {pilot} has the controls, at the operator's station")
