"""The sensor reference: kinds, what they read, what noise acts on, their own keys."""

from tools.reference.markdown import code, plain, table

from uwsim import _core
from uwsim.readings import READINGS

HEAD = """# Sensors

The kinds of sensor that a vehicle's file may carry, from the core's own table. `rov.sensors["imu"].read()` returns a
number in the unit below, or a reading with these fields (`uwsim.readings`). [Scenario files](scenario.md) lists the
keys that all kinds share: mount, rate, latency, drop-outs, noise.

"""


def sensors_page() -> str:
    """Return the page, with a section for each kind."""
    return HEAD + "\n".join(_section(_core.sensor_kind(name)) for name in _core.sensor_kinds())


def _section(kind: _core.SensorKind) -> str:
    reads = f"`{READINGS[kind.name].__name__}`" if kind.name in READINGS else "a number"
    text = f"## {kind.name}\n\n{plain(kind.meaning)}. It reads {reads}.\n\n"
    rows = [(code(name), _shape(width), plain(unit)) for name, (width, unit) in kind.fields.items()]
    text += table(("quantity", "shape", "unit"), rows)
    channels = [(code(name), _shape(width), plain(unit)) for name, (width, unit) in kind.channels.items()]
    text += "\nNoise acts on:\n\n" + table(("channel", "shape", "unit"), channels)
    keys = [
        (code(name), plain(parameter.unit), f"{parameter.low:g} ... {parameter.high:g}", f"{parameter.by_default:g}")
        for name, parameter in kind.parameters.items()
    ]
    return text + ("\nKeys of its own:\n\n" + table(("key", "unit", "range", "default"), keys) if keys else "")


def _shape(width: int) -> str:
    return "number" if width == 1 else f"({width},)"
