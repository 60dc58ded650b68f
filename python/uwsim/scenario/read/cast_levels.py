"""The levels of a cast: its columns and their units, and the samples of its way down, each deeper than those before."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats

Unit = tuple[float, float]  # factor and offset to the unit of ours
PRESSURE = "pressure_dbar"
LATITUDE_DEG = 45.0
METRES = dict.fromkeys(("", "m", "meter", "meters", "metre", "metres"), (1.0, 0.0))
FEET = dict.fromkeys(("ft", "feet", "foot"), (0.3048, 0.0))
BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]?.*")
NOT_IN_NAME, NOT_IN_UNIT = re.compile(r"[^a-z0-9]"), re.compile(r"[^a-z0-9/%‰]")


@dataclass(frozen=True)
class Quantity:
    """names: of its columns, in small letters and digits. units: by their texts in small letters, without spaces."""

    names: frozenset[str]
    units: dict[str, Unit]


def _named(names: str, units: dict[str, Unit]) -> Quantity:
    return Quantity(frozenset(names.split()), units)


QUANTITIES = {
    "depth_m": _named("depth dep depsm depfm depthm waterdepth", {**METRES, **FEET, "fathoms": (1.8288, 0.0)}),
    PRESSURE: _named(
        "pressure press pres p pr prm prdm prsm ctdprs pressuredbar pressurestraingauge",
        {
            **dict.fromkeys(("", "db", "dbar", "dbars", "decibar", "decibars"), (1.0, 0.0)),
            "bar": (10.0, 0.0),
            "kpa": (0.1, 0.0),
            "mpa": (100.0, 0.0),
            "psi": (0.6894757, 0.0),
        },
    ),
    "temperature_deg_c": _named(
        "temperature temp tempe ctdtmp tempct tempc t watertemperature temperaturedegc "
        "t090 t090c t068 t068c tv290c tv268c tnc90c t090f t068f tv290f",
        {
            **dict.fromkeys(("", "c", "degc", "celsius", "degreescelsius", "its90", "its90degc", "deg"), (1.0, 0.0)),
            **dict.fromkeys(("f", "degf", "fahrenheit", "its90degf"), (5.0 / 9.0, -160.0 / 9.0)),
            **dict.fromkeys(("its68degc", "ipts68", "its68"), (1.0 / 1.00024, 0.0)),
        },
    ),
    "salinity_psu": _named(
        "salinity sal salin psal sal00 ctdsal salinitypsu practicalsalinity salinitypractical",
        dict.fromkeys(("", "psu", "pss78", "pss", "practicalsalinityscale", "ppt", "o/oo", "‰", "1e3"), (1.0, 0.0)),
    ),
    "density_kg_m3": _named("densitykgm3", {"": (1.0, 0.0)}),
    "sound_speed_m_s": _named(
        "sound soundspeed soundvelocity soundspeedms soundvelocitycalc speedofsound sv svel sos svp veloc "
        "velocity speed svcm svdm svwm calcsv svms",
        {
            **dict.fromkeys(
                ("", "calc", "m/s", "ms", "ms1", "m/sec", "meterspersecond", "metersperseconds"), (1.0, 0.0)
            ),
            **dict.fromkeys(("ft/s", "ft/sec", "feetpersecond", "fps"), (0.3048, 0.0)),
        },
    ),
}
"""By the keys of a profile's levels. Densities of instruments are not read: their names omit the pressure."""


def quantity_of(label: str) -> tuple[str, str | None] | None:
    """Return the key of the quantity that a column's name states, and the unit in its brackets, if there is one."""
    text = label.strip().strip('"').lower()
    unit = None
    if found := BRACKETS.search(text):
        unit, text = found[1], text[: found.start()]
    elif ";" in text:
        text, unit = text.split(";")[:2]
    name = NOT_IN_NAME.sub("", text)
    key = next((key for key, quantity in QUANTITIES.items() if name in quantity.names), None)
    if key == PRESSURE and unit is not None and NOT_IN_UNIT.sub("", unit) in ("m", *FEET):
        key = "depth_m"  # of probes that compute it
    return None if key is None else (key, unit)


def unit_of(key: str, unit: str) -> Unit:
    """Return factor and offset of a unit. Raises ValueError for one that is not known."""
    units = QUANTITIES[key].units
    plain = NOT_IN_UNIT.sub("", unit.lower())
    if plain not in units and (last := NOT_IN_UNIT.sub("", unit.lower().split(",")[-1])) in units:
        plain = last
    if plain not in units:
        raise ValueError(f"unit '{unit.strip():.20}': must be one of {', '.join(filter(None, units))}")
    return units[plain]


def depth_at_m(pressure_dbar: Floats, latitude_deg: float = LATITUDE_DEG) -> Floats:
    """Return the depths [m] at gauge pressures [dbar], in sea water of 35 psu and 0 deg C.

    Fofonoff and Millard 1983, "Algorithms for computation of fundamental properties of seawater", Unesco technical
    papers in marine science 44, eqs. 25 and 26: 9712.653 m at 10,000 dbar in latitude 30. From 0 to 10,000 dbar.
    Between equator and pole, depths at one pressure differ by 0.53 %; in fresh water they are 2.8 % larger.
    """
    p, sine2 = pressure_dbar, np.sin(np.radians(latitude_deg)) ** 2
    gravity = 9.780318 * (1.0 + (5.2788e-3 + 2.36e-5 * sine2) * sine2) + 1.092e-6 * p
    polynomial = (((-1.82e-15 * p + 2.279e-10) * p - 2.2512e-5) * p + 9.72659) * p
    return np.asarray(polynomial / gravity, np.float64)


MOST_LEVELS = 10_000


class Range(Protocol):
    """The lowest and the highest value, and their unit."""

    low: float
    high: float
    unit: str


Limits = Mapping[str, Range]
"""By the keys of a profile's levels."""


class Columns(NamedTuple):
    """The samples of a file. values: by the keys of levels, or PRESSURE [dbar]. lines: of text, one a sample."""

    values: dict[str, Floats]
    lines: list[int]
    notes: list[str]


@dataclass(frozen=True, eq=False)
class Cast:
    """A cast from the surface down. columns: by the keys of a profile's levels. lines: of the file, one for each level.

    lines: empty for a file that is no text. notes: what was left out or assumed.
    """

    columns: Mapping[str, Floats]
    lines: Sequence[int]
    notes: Sequence[str]


def levels_of(name: str, columns: dict[str, Floats], lines: list[int], notes: list[str], limits: Limits) -> Cast:
    """Return a cast's way down, or up if it has no other, each sample deeper than those before. Raises ValueError."""
    pressure = columns.pop(PRESSURE, None)
    if "depth_m" not in columns:
        if pressure is None:
            raise ValueError(f"{name}: has neither depth nor pressure")
        columns["depth_m"] = depth_at_m(pressure)
        notes.append(f"depths follow from pressure, as of sea water in latitude {LATITUDE_DEG:g}")
    for key in ("temperature_deg_c", "salinity_psu", "sound_speed_m_s"):
        values = columns.get(key)
        if values is None:
            continue
        empty = np.isnan(values) | (
            (values == 0.0) if key == "sound_speed_m_s" or not np.nansum(np.abs(values)) else False
        )
        columns[key] = np.where(empty, np.nan, values)
        if empty.all():
            del columns[key]
            notes.append(f"{key} has no values, or only zeros")
    if columns.keys() <= {"depth_m", "salinity_psu", "density_kg_m3"}:
        raise ValueError(f"{name}: has neither sound speed nor temperature")
    depth = columns["depth_m"]
    kept = np.arange(len(depth))
    kept = _without(kept, ~np.isnan(np.sum(list(columns.values()), axis=0)), "without a value", notes)
    kept = _without(kept, depth[kept] >= 0.0, "above the surface", notes)
    if not len(kept):
        raise ValueError(f"{name}: has no sample with all values below the surface")
    _require_in(name, columns, lines, kept, limits)
    deepest = int(np.argmax(depth[kept]))
    begin = deepest - int(np.argmin(depth[kept[: deepest + 1]][::-1]))
    ways = {"down": _deeper(kept[begin : deepest + 1], depth), "up": _deeper(kept[deepest:][::-1], depth)}
    way = "up" if len(ways["up"]) > 4 * len(ways["down"]) else "down"
    chosen = ways[way]
    if left := len(kept) - len(chosen):
        notes.append(f"the way {way} is used, without {left} samples before, after, or not deeper than one before")
    if (step := math.ceil(len(chosen) / MOST_LEVELS)) > 1:
        notes.append(f"one of {step} samples is used, since a profile has at most {MOST_LEVELS} levels")
        chosen = chosen[::step]
    return Cast(
        {key: values[chosen] for key, values in columns.items()}, [lines[k] for k in chosen] if lines else [], notes
    )


def _deeper(kept: NDArray[np.intp], depth: Floats) -> NDArray[np.intp]:
    """Return the samples that are deeper than all before."""
    deeper = np.concatenate([[True], depth[kept][1:] > np.maximum.accumulate(depth[kept])[:-1]])
    return np.asarray(kept[deeper], np.intp)


def _require_in(
    name: str, columns: dict[str, Floats], lines: list[int], kept: NDArray[np.intp], limits: Limits
) -> None:
    """Raise ValueError that names the first value outside its limits."""
    for key, limit in limits.items():
        low, high, unit = limit.low, limit.high, limit.unit
        values = columns[key][kept] if key in columns else np.zeros(0)
        wrong = np.flatnonzero(~((values >= low) & (values <= high)))
        if len(wrong):
            at = f"{name}:{lines[kept[wrong[0]]]}" if lines else f"{name}, sample {kept[wrong[0]] + 1}"
            others = f", as for {len(wrong) - 1} others" if len(wrong) > 1 else ""
            raise ValueError(
                f"{at}: {key} = {values[wrong[0]]:.7g} {unit}: must be in [{low:g}, {high:g}] {unit}{others}"
            )


def _without(kept: NDArray[np.intp], good: NDArray[np.bool_], what: str, notes: list[str]) -> NDArray[np.intp]:
    if left := int(np.count_nonzero(~good)):
        notes.append(f"{left} samples {what} are left out")
    return kept[good]
