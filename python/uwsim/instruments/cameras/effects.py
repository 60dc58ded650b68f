"""Names of the effects available for pictures."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from uwsim import _core
from uwsim.base.named import did_you_mean

EFFECTS: tuple[str, ...] = tuple(_core.effect_names())
"""All effects: attenuation, backscatter, sunlight (daylight attenuated by Kd and refracted at the surface), surface
(reflection and refraction there), shadows, lamps, caustics, shafts, particles, wobble, distortion, vignetting, exposure
(automatic; without it, fixed at 1), noise and shutter (motion during exposure and readout)."""
WHOLE = {"on": "all effects", "off": "no effect"}


def effects_on(effects: str | Collection[str]) -> list[str]:
    """Return the names of the enabled effects.

    effects: "on" (all), "off" (none), one name or several. Raises ValueError for an unknown name.
    """
    if effects == "on":
        return list(EFFECTS)
    if effects == "off":
        return []
    names = [effects] if isinstance(effects, str) or not isinstance(effects, Iterable) else list(effects)
    for name in names:
        if name not in (*EFFECTS, "on", "off"):
            hint = did_you_mean(str(name), EFFECTS)
            raise ValueError(f"effects = {name!r}: must be 'on', 'off' or names of {', '.join(EFFECTS)}{hint}")
    for name in names:
        if name in ("on", "off"):
            raise ValueError(f"effects = {names}: '{name}' must be used alone: it means {WHOLE[name]}")
    return names
