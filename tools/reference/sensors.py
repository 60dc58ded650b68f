"""The sensor reference: kinds, with their quantities, noise channels and specific keys, and the packaged sensors."""

import math

from tools.reference.markdown import code, plain, table

from uwsim.instruments.readings import READINGS
from uwsim.scenario.read.assets import packaged_names
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import DerivedKind, SensorKind, usable_sensor_kinds
from uwsim.scenario.spec.vehicle import VehicleModel

HEAD = """# Sensors

The kinds of sensor that a vehicle's file may contain, generated from their table. `rov.sensors["imu"].read()`
returns a number in the unit below, or an object with these fields (`uwsim.instruments.readings`).
[Scenario files](scenario.md) lists the keys that all kinds share: mount, rate, latency, drop-outs, noise.

"""


def sensors_page() -> str:
    """Return the page, with a section for each kind."""
    return HEAD + "\n".join(_section(kind) for kind in usable_sensor_kinds())


def _with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOU' else 'a'} `{name}`"


def _section(kind: SensorKind) -> str:
    reads = _with_article(READINGS[kind.name].__name__) if kind.name in READINGS else "a number"
    reads = "an object with these fields" if isinstance(kind, DerivedKind) and len(kind.fields) > 1 else reads
    meaning = plain(kind.meaning)
    text = f"## {kind.name}\n\n{meaning[:1].upper()}{meaning[1:]}. A reading is {reads}.\n\n"
    rows = [(code(name), _shape(width), plain(unit)) for name, (width, unit) in kind.fields.items()]
    text += table(("quantity", "shape", "unit"), rows)
    channels = [(code(name), _shape(width), plain(unit)) for name, (width, unit) in kind.channels.items()]
    text += "\nNoise is added to:\n\n" + table(("channel", "shape", "unit"), channels)
    keys = [
        (code(name), plain(parameter.unit), f"{parameter.low:g} ... {parameter.high:g}", _default(parameter.by_default))
        for name, parameter in kind.parameters.items()
    ]
    text += "\nAdditional keys:\n\n" + table(("key", "unit", "range", "default"), keys) if keys else ""
    return text + _packaged(kind.name)


def _packaged(kind: str) -> str:
    """Return the table of the packaged vehicles' sensors of a kind; vehicles with equal sensors share a row."""
    vehicles: dict[tuple[str, ...], list[str]] = {}
    for vehicle in packaged_names("vehicles"):
        for name, mount in read_spec(VehicleModel, vehicle, "vehicles").sensors.items():
            if mount.kind == kind:
                vehicles.setdefault((code(name), *_figures(mount)), []).append(vehicle)
    rows = [(", ".join(who), *line) for line, who in vehicles.items()]
    head = ("vehicles", "name", "rate [Hz]", "latency [s]", "drop-outs", "noise")
    return "\nValues in the packaged vehicles, whose files cite the sources:\n\n" + table(head, rows) if rows else ""


def _figures(mount: SensorMount) -> tuple[str, ...]:
    rate = "each step" if mount.rate_hz is None else f"{mount.rate_hz:g}"
    shared = mount.noise or (Noise(std=mount.noise_std) if mount.noise_std else None)
    noises = {**({"": shared} if shared else {}), **mount.channels}
    noise = "<br>".join(f"{code(channel)} {_said(each)}".strip() for channel, each in noises.items())
    return rate, f"{mount.latency_s:g}", f"{mount.drop_out:g}", noise or "none"


def _said(noise: Noise) -> str:
    """Return the keys that are set, with their values."""
    return ", ".join(f"{key} {_value(value)}" for key, value in noise.model_dump(exclude_defaults=True).items())


def _value(value: float | tuple[float, float]) -> str:
    return " ... ".join(f"{each:g}" for each in value) if isinstance(value, tuple) else f"{value:g}"


def _default(value: float) -> str:
    return "must be given" if math.isnan(value) else f"{value:g}"


def _shape(width: int) -> str:
    return "number" if width == 1 else f"({width},)"
