"""The keys and the pilot's hands, which convert them to efforts that expire without further input.

A terminal reports that a key was typed, and again as it repeats, but not that it was released. Of several keys held
down, only the last one repeats, and the others last as long as it does.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

from uwsim.base.axes import AXES
from uwsim.channels.families.key import Function

FIRST_HOLD_S = 0.7  # keyboards wait 0.25 to 0.66 s before they repeat
REPEAT_HOLD_S = 0.25  # keyboards repeat at 10 Hz or more; the rest is a margin for slow networks
STALL_S = 1.0  # time without a beat after which all keys are released, since their pilot sees nothing
SHARES = (0.1, 0.25, 0.5, 0.75, 1.0)
ZERO = dict.fromkeys(AXES, 0.0)

DRIVING: dict[str, tuple[str, float]] = {
    "w": ("surge", 1.0), "s": ("surge", -1.0), "a": ("sway", 1.0), "d": ("sway", -1.0),
    " ": ("heave", 1.0), "b": ("heave", -1.0), "i": ("pitch", 1.0), "k": ("pitch", -1.0),
    "j": ("roll", -1.0), "l": ("roll", 1.0), "q": ("yaw", 1.0), "e": ("yaw", -1.0),
}  # fmt: skip
"""Axis and direction of each driving key, following REP 103: positive pitch is nose down, positive yaw turns to
port."""
TILTING = {",": Function.TILT_DOWN, ".": Function.TILT_UP}
"""Keys that tilt the sonar while they are held."""
SWITCHES = {
    "r": Function.RELEASE, "[": Function.FRONT_OFF, "]": Function.FRONT_ON,
    ";": Function.DOWN_OFF, "'": Function.DOWN_ON,
}  # fmt: skip
STEPS = {"-": -1, "=": 1}
"""Keys that change the share of full effort."""
SERVICES = {"u": "undock", "y": "dock", "z": "override_failsafe"}
"""Keys for services that this project's servers offer in addition to the published wire."""
ALL_STOP, END_STOP, LET_GO, HELP = "x", "X", "c", "?"
HELP_TEXT = """w s ahead, astern   a d to port, to starboard   space b up, down   q e turn   i k nose down, up
j l roll   x X all stop, its end   c zero, and give the helm away   - = effort   r release
u y undock, dock   z end failsafe   [ ] front light off, on   ; ' down light off, on   , . tilt the sonar
Ctrl-Q quit"""


class Hands:
    """The pilot's current commands. May be read on any thread.

    share: the effort of a key as a fraction of full effort. has_helm: whether the pilot is steering, which begins with
    the first driving key.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._lock = clock, threading.Lock()
        self._held: dict[str, float] = {}  # clock time until which each key holds
        self._beaten_s = math.inf
        self.share, self.has_helm = 0.5, False

    def beat(self) -> None:
        """Signal that the screen is alive. After the first call, this must be called several times per second."""
        self._beaten_s = self._clock()

    def press(self, key: str) -> None:
        """Record that a key was typed or has repeated."""
        with self._lock:
            if key in STEPS:
                self.share = SHARES[min(max(SHARES.index(self.share) + STEPS[key], 0), len(SHARES) - 1)]
            elif key in (ALL_STOP, LET_GO):
                self._held.clear()
                self.has_helm = key == ALL_STOP
            elif key in DRIVING or key in TILTING:
                self._hold(key)

    def _hold(self, key: str) -> None:
        now_s = self._clock()
        self._forget(now_s)
        self.has_helm = self.has_helm or key in DRIVING
        hold_s = REPEAT_HOLD_S if key in self._held else FIRST_HOLD_S
        axis = DRIVING.get(key, (key,))[0]
        held = {other for other in self._held if DRIVING.get(other, (other,))[0] != axis}  # the opposite key ends
        self._held = {each: max(self._held.get(each, -math.inf), now_s + hold_s) for each in {key, *held}}

    def drop(self) -> None:
        """Release all keys; each must be pressed again."""
        with self._lock:
            self._held.clear()

    def efforts(self) -> dict[str, float]:
        """Return the current efforts, in [-1, 1] by axis."""
        with self._lock:
            self._forget(self._clock())
            held = dict(DRIVING[key] for key in self._held if key in DRIVING)  # one key an axis: see _hold
            return ZERO | {axis: self.share * direction for axis, direction in held.items()}

    def tilt(self) -> Function:
        """Return the command for the sonar head: tilt while a tilt key is held down, otherwise hold."""
        with self._lock:
            self._forget(self._clock())
            return next((TILTING[key] for key in self._held if key in TILTING), Function.TILT_HOLD)

    def _forget(self, now_s: float) -> None:
        """Remove keys whose hold time has expired."""
        is_alive = now_s - self._beaten_s <= STALL_S
        self._held = {key: until_s for key, until_s in self._held.items() if is_alive and until_s > now_s}
