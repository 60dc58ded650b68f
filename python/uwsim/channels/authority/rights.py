"""The policy on who may command a vehicle, and who may change its world.

- All stop may be set by any client at any time.
- While a pilot at the operator's station has the controls, all other commands of other clients to a vehicle are
  refused, on every bridge: its command topics (/key, /cmd_vel, ...), its command services (/release, /dock, ...), its
  lamps, and the release of all stop. Any command in effect when the pilot takes the controls ends at that moment.
- Services of the simulation stay open, since they do not drive: pace, parameters, pictures, maps.
- Without a pilot, the last command takes effect. The station shows who issued it, and no page takes the controls
  automatically.
- While an exercise is flown, the world is closed to every client: parameters, faults, light, places, pace and jumps in
  time.
- Of the aids, such as holds, an exercise allows those that it names. Programs that command the vehicle are such an aid.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, Literal

from uwsim.base.commands import ALL_STOP, COMMANDS
from uwsim.live import ACTS, LiveSimulator
from uwsim.simulator.helm import Helm, Source

AidKind = Literal["autopilot", "hold", "program"]
"""The aids of a pilot: plans that the station flies, the vehicle's holds, and programs that command the vehicle."""
OF_EXERCISE = "an exercise is flown: no client may change the world or the pace of time"


class Rights:
    """The right to command the vehicles of one simulator, whose helms they are, and to change its world.

    permitted: called with the name of each command of a client other than the station's pilot, on any thread, when it
    is permitted. stopped: the same for all stop, which always is.
    """

    def __init__(self, helms: Iterable[Helm]) -> None:
        self._helms = tuple(helms)
        self.permitted: Callable[[str], object] = lambda name: None
        self.stopped: Callable[[str], object] = lambda name: None
        self._is_closed = False
        self._aids: frozenset[AidKind] | None = None  # all

    @property
    def pilot(self) -> str:
        """The name of the station's pilot, or ""."""
        return next((name for helm in self._helms if (name := helm.name_of(Source.PILOT))), "")

    def close_world(self, live: LiveSimulator) -> None:
        """Refuse clients' changes of the world and of the pace from now on, because an exercise is flown."""
        self._is_closed, live.refusal_of = True, self.refusal_of

    def allow_only(self, aids: Collection[AidKind]) -> None:
        """Refuse all other aids from now on."""
        self._aids = frozenset(aids)

    def refusal_of(self, act: str) -> str:
        """Return the reason why a client may not do something to the world, or ""; see LiveSimulator.refusal_of."""
        is_of_world = act in ACTS or (act in COMMANDS and COMMANDS[act].changes_world)
        return f"{act}: refused: {OF_EXERCISE}" if self._is_closed and is_of_world else ""

    def require_aid(self, aid: AidKind) -> None:
        """Raise ValueError if an exercise is flown that does not allow this aid."""
        if self._aids is not None and aid not in self._aids:
            raise ValueError(f"{aid}: refused: the exercise does not allow this aid")

    def require(self, name: str, request: Mapping[str, Any] | None = None) -> None:
        """Raise ValueError unless a client may currently use a command's topic or service with this request."""
        if name.rpartition("/")[2] == ALL_STOP and (request or {}).get("data") is not False:
            self.stopped(name)
            return
        if pilot := self.pilot:
            raise ValueError(f"/{name}: refused: {pilot} has the controls, at the operator's station")
        try:
            self.require_aid("program")
        except ValueError as error:
            raise ValueError(f"/{name}: {error}; the pilot at the operator's station flies") from None
        self.permitted(name)
