"""The imaging sonar reference: the kinds, with their keys in a vehicle's file and in Python."""

import math
from typing import Any

from tools.reference.markdown import code, plain, table

from uwsim import _core
from uwsim.scenario.spec.imaging_sonar import DEGREES, RADIANS, STRENGTHS, imaging_kind
from uwsim.scenario.spec.sensor_kind import SensorFigure

HEAD = """# Imaging sonars

The kinds under `imaging_sonars:` of a vehicle's file, generated from the core's table; [sonar
simulation](../guides/sonars.md) has an example. Each kind also has `position_m` and `yaw_pitch_roll_deg`, its mount on
the body. In Python, `uwsim.instruments.sonars.imaging` has the same parameters, with angles in radians under names that
end in `_rad`.

"""


def imaging_page() -> str:
    """Return the page, with a section for each kind."""
    return HEAD + "\n".join(_section(name) for name in _core.imaging_kinds())


def _section(name: str) -> str:
    kind = imaging_kind(name)
    model = kind.model()
    meaning = plain(kind.meaning)
    rows = [_row(key, parameter, getattr(model, key)) for key, parameter in kind.parameters.items()]
    strengths = "backscatter strength of each surface by name, instead of its material's"
    rows.append((code(STRENGTHS), "dB", "", "none", strengths))
    head = ("key", "unit", "range", "default", "meaning")
    return f"## {name}\n\n{meaning[:1].upper()}{meaning[1:]}.\n\n" + table(head, rows)


def _row(name: str, parameter: SensorFigure, value: Any) -> tuple[str, ...]:
    turned = name.endswith(RADIANS)
    scale = math.degrees if turned else float
    key = name.removesuffix(RADIANS) + DEGREES if turned else name
    unit = "deg" if turned else parameter.unit
    if parameter.type == "flag":
        return code(key), unit, "true or false", str(bool(value)).lower(), plain(parameter.meaning)
    default = "none" if value is None else f"{scale(value):.6g}"
    low = "above 0" if 0.0 < parameter.low < 1e-300 else f"{scale(parameter.low):.6g}"
    limits = f"{low} ... {scale(parameter.high):.6g}"
    return code(key), plain(unit), limits, default, plain(parameter.meaning)
