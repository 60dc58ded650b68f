"""Gamepads via SDL (pygame-ce, the extra 'gamepad'), with the same stick and button assignments as the station's page.

The sticks work as on most ROVs: the left one climbs and turns, the right one moves ahead and sideways. SDL's database
maps all known gamepads to the same names (SDL_GameControllerAxis, SDL_GameControllerButton).
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import Any, Protocol

from uwsim.operator.teleop.keys import ALL_STOP, LESS, MARK, MORE

DEAD_ZONE = 0.12
FULL = 32767  # full deflection of an SDL axis
STICKS = (("yaw", -1.0), ("heave", -1.0), ("sway", -1.0), ("surge", -1.0))  # SDL: left x, left y, right x, right y
BUTTONS = {
    0: ALL_STOP, 1: MARK, 2: "]", 3: "[", 6: "r", 9: LESS, 10: MORE, 11: ".", 12: ",", 13: ";", 14: "'",
}  # fmt: skip
"""SDL's button numbers: a, b, x, y, start, left and right shoulder, D-pad up, down, left, right."""


class Pad(Protocol):
    """An SDL game controller."""

    def get_axis(self, axis: int) -> int:
        """Return the position of an axis, -32768 to 32767."""

    def get_button(self, button: int) -> bool:
        """Return whether a button is down."""


def shaped(value: int) -> float:
    """Map an axis to [-1, 1], with no drift at rest, fine control near the centre and full scale at the end."""
    size = min(abs(value) / FULL, 1.0)
    if size < DEAD_ZONE:
        return 0.0
    share = ((size - DEAD_ZONE) / (1.0 - DEAD_ZONE)) ** 1.5
    return float(-share if value < 0 else share)


def stick_efforts(pad: Pad) -> dict[str, float]:
    """Return the efforts commanded by the sticks, by axis."""
    return {axis: sign * shaped(pad.get_axis(k)) for k, (axis, sign) in enumerate(STICKS)}


class Gamepads:
    """The first connected gamepad. name: "" if there is none. is_possible: whether pygame-ce is installed."""

    def __init__(self) -> None:
        self.name = ""
        self.is_possible = find_spec("pygame") is not None
        self._pad: Any = None
        self._pressed: set[int] = set()
        if self.is_possible:
            os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # no window, only gamepads
            os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
            os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
            import pygame
            from pygame._sdl2 import controller

            pygame.display.init()  # gamepads need its event loop
            controller.init()
            self._pygame, self._controller = pygame, controller

    def look(self) -> None:
        """Look for a gamepad if there is none, or check that the current one is still connected.

        Call this about once a second.
        """
        if not self.is_possible:
            return
        if self._pad is not None and not self._pad.attached():
            self._pad, self.name, self._pressed = None, "", set()
        if self._pad is None:
            for index in range(self._controller.get_count()):
                if self._controller.is_controller(index):
                    self._pad = self._controller.Controller(index)
                    self.name = str(self._pad.name)
                    return

    def poll(self) -> tuple[dict[str, float], list[str], list[str]]:
        """Return the stick efforts, and the keys whose buttons have just been pressed and released."""
        if self._pad is None:
            return {}, [], []
        self._pygame.event.pump()
        return self.read(self._pad)

    def read(self, pad: Pad) -> tuple[dict[str, float], list[str], list[str]]:
        """Like `poll`, but for the gamepad passed."""
        down = {button for button in BUTTONS if pad.get_button(button)}
        pressed, released = down - self._pressed, self._pressed - down
        self._pressed = down
        return stick_efforts(pad), [BUTTONS[b] for b in sorted(pressed)], [BUTTONS[b] for b in sorted(released)]
