"""The action of each key: those of the published keyboard, plus a few additional keys."""

from __future__ import annotations

from uwsim.channels.families.key import Function

DRIVING: dict[str, tuple[str, float]] = {
    "w": ("surge", 1.0), "s": ("surge", -1.0),
    "a": ("sway", 1.0), "d": ("sway", -1.0),
    " ": ("heave", 1.0), "b": ("heave", -1.0),
    "i": ("pitch", 1.0), "k": ("pitch", -1.0),
    "j": ("roll", -1.0), "l": ("roll", 1.0),
    "q": ("yaw", 1.0), "e": ("yaw", -1.0),
}  # fmt: skip
"""Axis and direction of each driving key, following REP 103: positive pitch is nose down, positive yaw turns to
port."""
TILTING = {",": Function.TILT_DOWN, ".": Function.TILT_UP}
"""Keys that tilt the sonar while they are held."""
SWITCHES = {
    "r": Function.RELEASE,
    "[": Function.FRONT_OFF,
    "]": Function.FRONT_ON,
    ";": Function.DOWN_OFF,
    "'": Function.DOWN_ON,
}
SERVICES = {"u": "undock", "y": "dock", "z": "override_failsafe"}
"""Keys for services that this project's servers offer in addition to the published wire."""
ALL_STOP, END_STOP, LET_GO, MARK, LESS, MORE, HELP = "x", "X", "c", "m", "-", "=", "?"

HELP_TEXT = """\
w s  ahead, astern        q e  turn to port, to starboard    a d  to port, to starboard
space b  up, down         i k  nose down, up                 j l  roll to port, to starboard
- =  less, more effort    x X  all stop, and its release     c    zero, and give the helm away
r    release              u y  undock, dock                  m    mark this place
[ ]  front light off, on  ; '  down light off, on            , .  tilt the sonar down, up
z    override failsafe    ?    this help                     Ctrl-Q  quit"""
