"""The pilot's hands: converts keys and sticks to efforts, which expire without further input.

A terminal reports that a key was typed, and again as it repeats, but not that it was released. An effort therefore
lasts for FIRST_HOLD_S after a key is first typed, by which time a keyboard has started to repeat, and for REPEAT_HOLD_S
after each repeat. Of several keys held down, only the last one repeats, and the others last as long as it does.
Terminals with the kitty keyboard protocol (https://sw.kovidgoyal.net/kitty/keyboard-protocol/) report when a key is
released, so an effort lasts until then.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping

from uwsim.base.axes import AXES
from uwsim.channels.families.key import Function
from uwsim.operator.teleop.keys import ALL_STOP, DRIVING, LET_GO, TILTING

FIRST_HOLD_S = 0.7  # keyboards wait 0.25 to 0.66 s before they repeat
REPEAT_HOLD_S = 0.25  # keyboards repeat at 10 Hz or more; the rest is a margin for slow networks
STALL_S = 1.0  # time without a beat after which all keys are released, since a hung screen misses their releases
SHARES = (0.1, 0.25, 0.5, 0.75, 1.0)
ZERO = dict.fromkeys(AXES, 0.0)


class Hands:
    """The pilot's current commands. May be read on any thread.

    adds_up: whether each press of a driving key adds to its axis or subtracts, and the sum lasts, as in the published
    keyboard node. has_helm: whether the pilot is steering, which begins with the first driving key or stick movement.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, *, adds_up: bool = False) -> None:
        self._adds_up = adds_up
        self._sums = dict(ZERO)
        self._clock = clock
        self._lock = threading.Lock()
        self._held: dict[str, float] = {}  # clock time until which each key holds
        self._sticks: dict[str, float] = {}
        self._share = SHARES.index(0.5)
        self._beaten_s = math.inf
        self.has_helm = False
        self.reports_releases = False  # whether the terminal reports released keys

    @property
    def share(self) -> float:
        """The effort of a key as a fraction of full effort."""
        return SHARES[self._share]

    def change_share(self, steps: int) -> None:
        """Make keys and sticks stronger or weaker by a number of steps."""
        self._share = min(max(self._share + steps, 0), len(SHARES) - 1)

    def beat(self) -> None:
        """Signal that the screen is alive. After the first call, this must be called several times per second."""
        self._beaten_s = self._clock()

    def press(self, key: str) -> None:
        """Record that a key was typed or has repeated."""
        with self._lock:
            if key == ALL_STOP:
                self._drop()
                self.has_helm = True
            elif key == LET_GO:
                self._drop()
                self.has_helm = False
            elif self._adds_up and key in DRIVING:
                self.has_helm = True
                axis, direction = DRIVING[key]
                self._sums[axis] = min(max(self._sums[axis] + direction, -1.0), 1.0)
            elif key in DRIVING or key in TILTING:
                self._hold(key)

    def _hold(self, key: str) -> None:
        now_s = self._clock()
        self._forget(now_s)
        self.has_helm = self.has_helm or key in DRIVING
        is_new = key not in self._held
        self._held = {other: until_s for other, until_s in self._held.items() if not _opposed(key, other)}
        hold_s = math.inf if self.reports_releases else FIRST_HOLD_S if is_new else REPEAT_HOLD_S
        for held in {key, *self._held}:
            self._held[held] = max(self._held.get(held, -math.inf), now_s + hold_s)

    def release(self, key: str) -> None:
        """Record that a key was released."""
        with self._lock:
            self._held.pop(key, None)

    def set_sticks(self, efforts: Mapping[str, float]) -> None:
        """Set the efforts from gamepad sticks, in [-1, 1] by axis, which are held until the next call."""
        with self._lock:
            self._sticks = dict(efforts)
            self.has_helm = self.has_helm or any(efforts.values())

    def drop(self) -> None:
        """Release all keys and sticks; each key must be pressed again."""
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        self._held.clear()
        self._sums = dict(ZERO)
        self._sticks = {}

    def efforts(self) -> dict[str, float]:
        """Return the current efforts, in [-1, 1] by axis."""
        with self._lock:
            self._forget(self._clock())
            efforts = dict(self._sums)
            for key in self._held:
                if key in DRIVING:
                    axis, direction = DRIVING[key]
                    efforts[axis] += direction
            for axis, effort in self._sticks.items():
                efforts[axis] += effort
            return {axis: self.share * min(max(effort, -1.0), 1.0) for axis, effort in efforts.items()}

    def tilt(self) -> Function:
        """Return the command for the sonar head: tilt while a tilt key is held down, otherwise hold."""
        with self._lock:
            self._forget(self._clock())
            return next((TILTING[key] for key in self._held if key in TILTING), Function.TILT_HOLD)

    def _forget(self, now_s: float) -> None:
        """Remove keys whose hold time has expired."""
        if now_s - self._beaten_s > STALL_S:
            self._drop()
        self._held = {key: until_s for key, until_s in self._held.items() if until_s > now_s}


def _opposed(key: str, other: str) -> bool:
    """Return whether two keys drive the same axis in opposite directions."""
    return key != other and key in DRIVING and other in DRIVING and DRIVING[key][0] == DRIVING[other][0]
