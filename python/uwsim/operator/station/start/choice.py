"""Validates the choice made on the start screen, field by field, and converts it to a scenario."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from uwsim.channels.guest import Values
from uwsim.exercises.exercise import exercise_names, load_exercise
from uwsim.live.pace import Speed, checked_speed
from uwsim.operator.station.start.user_rosbridge import UserRosbridge, checked_host, checked_port, checked_ros
from uwsim.scenario import Scenario, ScenarioError, VehicleModel, load, load_vehicle, packaged_scenarios
from uwsim.scenario.read.assets import packaged_names
from uwsim.scenario.spec.link import load_modem
from uwsim.scenario.spec.sonar import WIRE_NUMBERS, load_sonar
from uwsim.scenario.spec.vehicle_entry import SonarSetup

OF_ROSBRIDGE = ("rosbridge_host", "rosbridge_port", "rosbridge_ros")
FIELDS = ("scenario", "vehicle", "sonar", "tilt_deg", "mission_time_s", "seed", "speed", "link", *OF_ROSBRIDGE)
TILTS_DEG = (0.0, 60.0)
"""Tilts of the sonar's head, down: level as the published simulator starts, or as its lawn-mower needs it."""
GROUPS = {
    "lakes": ("lake", "tarn", "lake_tethered", "lake_boat", "lake_tender", "reservoir", "valley", "paper",
              "paper_buoyant"),
    "sea": ("reef", "kelp", "lagoon", "cove", "shelf"),
    "structures": ("wreck", "harbour", "fish_farm", "wind_farm"),
    "basins": ("training_pool", "course", "pool", "panel", "pair"),
}  # fmt: skip
"""The packaged scenes as the start screen groups them; all others are the user's own."""
SPEEDS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 0.0)


class ChoiceError(ValueError):
    """Raised for an invalid choice. Contains the errors by field."""

    def __init__(self, errors: dict[str, str]) -> None:
        super().__init__("; ".join(errors.values()))
        self.errors = errors


def chosen(
    choice: Values, offered: str = "lake", saved: Mapping[str, Path] = MappingProxyType({})
) -> tuple[Scenario, Speed]:
    """Return the scenario and the speed of a choice. Raises ChoiceError.

    offered: a scenario that may be chosen in addition to the packaged ones. saved: further ones by name. Only names are
    accepted, not paths, since the page's user may not be allowed to read this machine's files.
    """
    errors: dict[str, str] = {name: "unknown field" for name in choice if name not in FIELDS}
    values = {name: choice.get(name) for name in FIELDS}
    known: dict[str, str | Path] = {**{name: name for name in scenarios(offered)}, **saved}
    scenario = _try(errors, "scenario", lambda: load(known[_name(values["scenario"] or offered, list(known))]))
    speed = _try(errors, "speed", lambda: _speed(values["speed"]))
    _try(errors, "link", lambda: _link(values["link"]))
    if scenario is not None:
        scenario = with_choice(scenario, values, errors)
    _rosbridge(errors, values)
    if errors or scenario is None or speed is None:
        raise ChoiceError(errors)
    return scenario, speed


def with_choice(scenario: Scenario, values: Values, errors: dict[str, str]) -> Scenario:
    """Return a scenario with the choice's vehicle, sonar and its tilt, time, seed and link. Adds to `errors`."""
    changes: dict[str, Callable[[], dict[str, Any]]] = {
        "vehicle": lambda: {"vehicle_model": _vehicle(values.get("vehicle"))},
        "sonar": lambda: _sonar(values.get("sonar")),
        "tilt_deg": lambda: {"sonar_tilt_deg": values.get("tilt_deg")},
        "mission_time_s": lambda: {"mission_time_s": values.get("mission_time_s")},
        "seed": lambda: {"seed": _whole(values.get("seed"), "seed")},
        "link": lambda: {"modem": _link(values.get("link"))},
    }
    for field, read in changes.items():
        if values.get(field) is not None:
            scenario = _try(errors, field, lambda: scenario.with_changes(**read())) or scenario  # noqa: B023
    return scenario


def chosen_save(choice: Values, known: Sequence[str]) -> tuple[str, Speed]:
    """Return the saved session that a choice continues, and the speed. Raises ChoiceError."""
    free = ("speed", "link", *OF_ROSBRIDGE)
    fixed = [name for name in FIELDS if name not in free and choice.get(name) is not None]
    errors = dict.fromkeys(fixed, "is as it was saved")
    session = _try(errors, "saved", lambda: _name(choice["saved"], known))
    speed = _try(errors, "speed", lambda: _speed(choice.get("speed")))
    _rosbridge(errors, choice)
    if errors:
        raise ChoiceError(errors)
    return session, speed


def chosen_flight(choice: Values) -> tuple[str, Speed]:
    """Return the (unchecked) name of the flight that a choice replays, and the speed. Raises ChoiceError."""
    errors = {name: "is as it was recorded" for name in FIELDS if name != "speed" and choice.get(name) is not None}
    speed = _try(errors, "speed", lambda: _speed(choice.get("speed")))
    if errors:
        raise ChoiceError(errors)
    return str(choice["flight"]), speed


def chosen_exercise(choice: Values, own: Mapping[str, Path] = MappingProxyType({})) -> str:
    """Return the packaged exercise, or one of own, that a choice names, which decides all else. Raises ChoiceError."""
    errors = {name: "is the exercise's own" for name in FIELDS if choice.get(name) is not None}
    name = _try(errors, "exercise_name", lambda: _name(choice["exercise_name"], [*own, *exercise_names()]))
    if errors:
        raise ChoiceError(errors)
    return str(name)


def chosen_rosbridge(choice: Values) -> UserRosbridge | None:
    """Return the user's rosbridge in a choice, after checking that it can be reached, or None. Raises ChoiceError."""
    errors: dict[str, str] = {}
    rosbridge = _rosbridge(errors, choice)
    if rosbridge is not None:
        _try(errors, "rosbridge_host", rosbridge.require_reachable)
    if errors:
        raise ChoiceError(errors)
    return rosbridge


def _rosbridge(errors: dict[str, str], choice: Values) -> UserRosbridge | None:
    """Return the user's rosbridge, or None if the address is empty or a field is invalid. Adds to `errors`."""
    if choice.get("rosbridge_host") is None:
        return None
    checks: dict[str, Callable[[object], Any]] = {
        "rosbridge_host": checked_host,
        "rosbridge_port": checked_port,
        "rosbridge_ros": checked_ros,
    }
    found = {name: _try(errors, name, partial(check, choice.get(name))) for name, check in checks.items()}
    if errors.keys() & checks.keys():
        return None
    return UserRosbridge(f"{found['rosbridge_host']}:{found['rosbridge_port']}", found["rosbridge_ros"])


def scenarios(offered: str) -> list[str]:
    """Return the names of scenarios that may be chosen."""
    names = packaged_scenarios()
    return names if offered in names else [offered, *names]


@cache
def catalog(offered: str = "lake") -> Values:
    """Return the available choices, with the settings of the scenario `offered` as defaults. The result is cached."""
    return {
        "scenarios": [described(name) for name in scenarios(offered)],
        "vehicles": [
            {"name": name, "description": load_vehicle(name).description} for name in packaged_names("vehicles")
        ],
        "sonars": _sonars(),
        "tilts_deg": list(TILTS_DEG),
        "exercises": [described_exercise(name) for name in exercise_names()],
        "links": [{"name": name, "description": load_modem(name).description} for name in _modems()],
        "speeds": list(SPEEDS),
        "defaults": {
            "scenario": offered, "vehicle": None, "sonar": None, "tilt_deg": None,
            "mission_time_s": None, "seed": None, "speed": 1.0,
            "link": link.modem.name if (link := load(offered).link) else "none",
            **dict.fromkeys(OF_ROSBRIDGE),
        },
    }  # fmt: skip


def described(name: str, path: Path | None = None) -> Values:
    """Return a scenario as the start screen lists it. path: of its file, if it is not packaged."""
    scenario = load(path or name)
    first = scenario.vehicles[0]
    return {
        "name": name,
        "group": next((group for group, names in GROUPS.items() if path is None and name in names), "own"),
        "description": " ".join(scenario.description.split()),
        "has_survey": scenario.survey is not None,
        "seed": scenario.seed,
        "mission_time_s": scenario.mission_time_s,
        "vehicles": [{"name": entry.name, "model": entry.model.name} for entry in scenario.vehicles],
        "sonar": first.sonar.title if first.model.sonar else None,
        "tilt_deg": first.sonar.tilt_deg if first.model.sonar else None,
    }


def described_exercise(name: str, path: Path | None = None) -> Values:
    """Return an exercise as the start screen lists it. path: of its file, if it is not packaged."""
    found = load_exercise(path or name)
    brief = " ".join(found.brief.split())
    return {"name": name, "title": found.title, "brief": brief, "scenario": found.scenario, "time_s": found.time_s,
            "points": found.points, "pass_points": found.pass_points}  # fmt: skip


def _sonars() -> list[Values]:
    """Return the four published models, by number, and the other multibeams, by name and one for each frequency."""
    found: list[Values] = []
    for name in packaged_names("sonars"):
        model = load_sonar(name)
        if (number := model.wire_number) is not None:
            found.append({"name": number, "title": f"Model {number}", "description": model.description,
                          "kind": "published"})  # fmt: skip
            continue
        for each in _at_frequencies(name):
            found.append({"name": each, "title": each, "description": model.description, "kind": "instrument"})
    return sorted(found, key=lambda sonar: (sonar["kind"] != "published", str(sonar["name"])))


def _at_frequencies(name: str) -> dict[str, dict[str, Any]]:
    """Return the arguments of `with_changes` for a multibeam at each frequency, by the names of the choices."""
    model = load_sonar(name)
    if len(model.frequencies) == 1:
        return {name: {"sonar_model": name}}
    return {
        SonarSetup(model=model, frequency_hz=band.frequency_hz).title: {
            "sonar_model": name, "sonar_frequency_hz": band.frequency_hz,
        }
        for band in model.frequencies
    }  # fmt: skip


def _try(errors: dict[str, str], field: str, make: Callable[[], Any]) -> Any:
    try:
        return make()
    except (ScenarioError, ValueError, OSError) as error:
        errors[field] = " ".join(str(error).split())
        return None


def _name(value: Any, known: Sequence[str]) -> str:
    if value not in known:
        raise ValueError(f"{str(value)[:40]!r}: must be one of {', '.join(known)}")
    return str(value)


def _vehicle(value: Any) -> VehicleModel | None:
    return None if value is None else load_vehicle(_name(value, packaged_names("vehicles")))


def _whole(value: Any, field: str) -> int | None:
    if value is None or (isinstance(value, int) and not isinstance(value, bool)):
        return value
    if isinstance(value, float) and value.is_integer():
        return int(value)
    raise ValueError(f"{field} = {str(value)[:40]}: must be a whole number")


def _sonar(value: Any) -> dict[str, Any]:
    """Return the arguments of `with_changes` for a choice of sonar. Raises ValueError."""
    if isinstance(value, str) and value.isascii() and value.isdigit():
        value = int(value)
    if isinstance(value, float):
        value = _whole(value, "sonar")
    if isinstance(value, int) and not WIRE_NUMBERS[0] <= value <= WIRE_NUMBERS[1]:
        raise ValueError(f"sonar = {value}: must be in {list(WIRE_NUMBERS)}, or a name")
    if value is None or (isinstance(value, int) and not isinstance(value, bool)):
        return {"sonar_model": value}
    known: dict[str, dict[str, Any]] = {name: {"sonar_model": name} for name in packaged_names("sonars")}
    for name in packaged_names("sonars"):
        known |= _at_frequencies(name)
    return known[_name(value, list(known))]


def _speed(value: Any) -> Speed:
    return "max" if value == 0 and not isinstance(value, bool) else checked_speed(1.0 if value is None else value)


def _link(value: Any) -> str | None:
    return None if value is None else _name(value, _modems())


def _modems() -> list[str]:
    """Return the packaged modems, `none` first."""
    return sorted(packaged_names("modems"), key=lambda name: (name != "none", name))
