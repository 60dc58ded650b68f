"""Hostile command lines: for each parameter of each command, values that no user should have to fear.

The commands and their parameters are read from the program itself, so that a new option is attacked without being named
here. Each line starts as a working one (BASES), in which one parameter gets a hostile value.
"""

from __future__ import annotations

import inspect
import json
import os
import random
import re
import typing
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import typer

HUGE = "9" * 400
NUMBERS = (
    "-1", "0", "1e-308", "-1e-308", "1e308", "inf", "-inf", "nan", "1e400", HUGE, str(2**63), str(-(2**64)), "", "x",
)  # fmt: skip
LONG = "x" * 5000
NOT_UTF8 = os.fsdecode(b"\xff\xfe\x80.bt")
TEXTS = (
    "", "/dev/full", "folder", "/proc/self", LONG, NOT_UTF8, "\x01\x1b[31m", "-", "nan", "../" * 60 + "x",
    "%s%n{}$(x)", "/dev/zero",
)  # fmt: skip
PATHS = frozenset({"/dev/full", "/dev/zero", "/proc/self"})
NONSENSE = PATHS | {"", LONG, "\x01\x1b[31m", "%s%n{}$(x)"}
MEANT = {
    ("exercise fly", "person"): PATHS | {"%s%n{}$(x)"},
    ("vehicle identify", "name"): frozenset({""}),
    **{(command, name): PATHS | {""} for command in ("serve", "ros connect") for name in ("namespace", "frame_prefix")},
}
"""Texts that mean something to a parameter of a command: a name, a token, a place in ROS's tree of names."""
NEEDS_MORE = {"scheduler": "a cluster", "ros1": "a ROS 1 master"}
"""Flags that are not tried by themselves."""

FILES: dict[str, Callable[[Path], object]] = {
    "a-folder": Path.mkdir,
    "empty": Path.touch,
    "noise": lambda path: path.write_bytes(random.Random(0).randbytes(4096)),
    "sparse": lambda path: (path.touch(), os.truncate(path, 100 << 20)),
    "fifo": os.mkfifo,
    "loop": lambda path: path.symlink_to(path.name),
    "secret": lambda path: path.touch(0),
}
"""Functions that create the hostile files, by stem. fifo: without a writer. secret: readable only by root."""
SUFFIX = re.compile(r"(?<![\w.])\w*(\.(?:bt|ot|mcap|bag|png|csv|json|ya?ml|py|obj|tif|ply))\b")

# Lines that work and end soon. SERVER marks those that end by SIGTERM.
SERVER = frozenset({"serve", "station", "ros connect", "teleop", "map view"})
BROWSING = ("station", "map view")
BASES: dict[str, tuple[list[str], dict[str, str]]] = {
    "survey": (["pool.yaml"], {"out": "out", "mission_time_s": "2", "report": "none"}),
    "run": (["mission.py"], {"scenario": "pool.yaml", "out": "out", "report": "none"}),
    "compare": (["mission.py"], {"scenario": "pool.yaml", "out": "out", "seeds": "0", "time_limit_s": "2"}),
    "sweep": (["sweep.yaml"], {"out": "out", "workers": "0"}),
    "exercise fly": (["hover"], {"pilot": "mission.py", "out": "out"}),
    "exercise check": (["score.json"], {}),
    "course new": (["team"], {}),
    "course world": (["pool-course", "world.yaml"], {}),
    "course bag": (["folder", "first.mcap"], {}),
    "course score": (["folder"], {"seeds": "seeds.txt", "out": "out", "workers": "0"}),
    "course table": (["folder"], {"out": "out"}),
    "vehicle identify": (["run.mcap"], {"vehicle": "rov", "out": "out"}),
    "fleet": (["pool.yaml"], {"tile": "100", "out": "out", "workers": "0"}),
    "serve": (["pool.yaml"], {"port": "0"}),
    "station": (["pool.yaml"], {"port": "0"}),
    "teleop": ([], {"scenario": "pool.yaml"}),
    "ros connect": (["ws://127.0.0.1:9"], {}),
    "ros doctor": ([], {"listen": "0.1"}),
    "recording info": (["run.mcap"], {}),
    "replay": (["run.mcap"], {"until_s": "0.1"}),
    "recording diff": (["run.mcap", "run.mcap"], {}),
    "scenario parameters": (["pool.yaml", "rov"], {}),
    "vehicle report": (["remus100"], {"out": "vehicle.html"}),
    "vehicle tune": (["remus100"], {"generations": "0", "population": "1", "out": "tuned"}),
    "scenario sonar": (["pool.yaml"], {"kind": "fan", "out": "sonar.png"}),
    "scenario rays": (["pool.yaml"], {"source": "0,0,-1", "receiver": "2,0,-1", "out": "rays.png"}),
    "validate": (["control"], {}),
    "scenario fingerprint": (["pool.yaml"], {}),
    "reproduce": (["paper"], {"out": "out"}),
    "scenario camera": (["pool.yaml"], {"out": "camera.png"}),
    "dataset": (["pool.yaml"], {"n": "1", "out": "out", "size": "32x24", "workers": "0"}),
    "recording film": (["pool.yaml"], {"out": "a.webp", "size": "16x10", "fps": "5", "until_s": "0.4", "workers": "0"}),
    "vehicle decompose": (["cube.obj"], {"out": "pieces.obj"}),
    "ros package": ([], {"out": "ros"}),
    "map info": (["map.bt"], {}),
    "map convert": (["map.bt", "cloud.ply"], {}),
    "map build": (["built.bt"], {"sources": "survey.gsf"}),
    "map from": (["run.mcap"], {"out": "from.bt"}),
    "map merge": (["map.bt", "map.bt"], {"out": "merged.bt"}),
    "map score": (["map.bt"], {"scenario": "pool.yaml", "out": "score.png"}),
    "map render": (["map.bt"], {"out": "map.png"}),
    "map diff": (["map.bt", "map.bt"], {}),
    "map view": (["map.bt"], {"port": "0"}),
    "map film": (["run.mcap"], {"out": "map.webp", "pictures": "2"}),
    "map waterfall": (["survey.xtf"], {"out": "waterfall.png"}),
    "map slice": (["map.bt"], {"z": "-1", "out": "slice.png"}),
    "scenario list": ([], {}),
    "scenario new": (["mine.yaml"], {}),
    "scenario check": (["pool.yaml"], {}),
    "scenario from": (["folder"], {"out": "unity"}),
    "scenario schema": (["scenario"], {}),
    "scenario plan": (["pool.yaml"], {"out": "pool.plan"}),
}
MORE_BASES: dict[str, list[tuple[list[str], dict[str, str]]]] = {
    "map build": [
        (["built.bt"], {"sources": "soundings.xtf"}),
        (["built.bt"], {"sources": "sea.xyz", "sensor_at": "5 5 0"}),
    ],
    "scenario from": [
        (["sea.xyz"], {"crs": "EPSG:32632", "cell": "1", "positive": "up", "out": "sea.yaml"}),
    ],
}
"""Further lines of commands in which some options have no effect by the first one."""
NOT_TRIED = {
    "bench": "its programs measure for minutes, and are for developers",
    "ardusub": "it needs a compiled ArduSub; test_firmware.py has its refusals",
}


class Parameter(NamedTuple):
    """A parameter of a command: option is "" for an argument; kind is int, float, str, Path or bool."""

    name: str
    option: str
    kind: type
    count: int
    info: Any

    @property
    def bounds(self) -> Any:
        """The object that typer calls with its value."""
        return self.info.callback


class Line(NamedTuple):
    """A command line without the program's name. value: the hostile value of `parameter`."""

    command: str
    parameter: str
    kind: type
    value: str
    words: tuple[str, ...]

    @property
    def is_nonsense(self) -> bool:
        """Return whether its value is a text that is meaningless for every parameter, except as the name of a file."""
        meant = MEANT.get((self.command, self.parameter), frozenset())
        return self.kind is str and self.value in NONSENSE - meant

    @property
    def is_about_a_file(self) -> bool:
        return Path(self.value).stem in FILES

    @property
    def is_server(self) -> bool:
        return self.command in SERVER or not {"--as-topics", "--serve"}.isdisjoint(self.words)


def commands() -> dict[str, list[Parameter]]:
    """Return the parameters of every command, as the program declares them."""
    from uwsim.base.sockets import load_all
    from uwsim.cli.groups import SOCKET

    return dict(_commands(load_all(SOCKET), ""))


def _commands(found: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, list[Parameter]]]:
    from uwsim.base.sockets import is_offered, load_all
    from uwsim.cli.flags import expanded
    from uwsim.cli.groups import SOCKET

    for name, each in found.items():
        if prefix + name in NOT_TRIED:
            continue
        if not isinstance(each, typer.Typer):
            yield prefix + name, list(_parameters(expanded(each)))
        else:
            of_group = {
                command.name or command.callback.__name__.replace("_", "-"): command.callback
                for command in each.registered_commands
            }
            of_group |= load_all(f"{SOCKET}.{name}") if is_offered(f"{SOCKET}.{name}") else {}
            yield from _commands(of_group, f"{prefix}{name} ")


def _parameters(callback: Any) -> Iterator[Parameter]:
    hints = typing.get_type_hints(callback, include_extras=True)
    for name in inspect.signature(callback).parameters:
        if hints[name] is typer.Context:
            continue
        hint, *infos = typing.get_args(hints[name])
        info = next(each for each in infos if hasattr(each, "param_decls"))
        parts = [part for part in (typing.get_args(hint) or (hint,)) if part is not type(None)]
        inner = [kind for part in parts for kind in (typing.get_args(part) or (part,))]
        is_tuple = typing.get_origin(hint) is tuple
        words = (info.default, *(info.param_decls or ()))  # typer takes the first name for a default until it is called
        declared = [word.split("/")[0] for word in words if isinstance(word, str) and word.startswith("--")]
        option = "" if type(info).__name__ == "ArgumentInfo" else (declared or [f"--{name.replace('_', '-')}"])[0]
        yield Parameter(name, option, inner[0], len(inner) if is_tuple else 1, info)


def lines() -> Iterator[Line]:
    """Yield all hostile lines, command by command."""
    for command, parameters in commands().items():
        for arguments, options in (BASES[command], *MORE_BASES.get(command, [])):
            yield from _of_base(command, parameters, arguments, options)


def _of_base(
    command: str, parameters: list[Parameter], arguments: list[str], options: dict[str, str]
) -> Iterator[Line]:
    by_name = {each.name: each for each in parameters}
    places = [each for each in parameters if not each.option]
    for parameter in parameters:
        place = places.index(parameter) if parameter in places else 0
        works = options.get(parameter.name, "") if parameter.option else "".join(arguments[place : place + 1])
        files = file_names(parameter.kind, works, parameter.info.help or "")
        for value in (*_values(parameter), *files):
            given = {name: [by_name[name].option, *text.split()] for name, text in options.items()}
            texts = list(arguments)
            if parameter.kind is bool:
                if parameter.name in NEEDS_MORE:
                    continue
                given[parameter.name] = [parameter.option]
            elif parameter.option:
                given[parameter.name] = (
                    [f"{parameter.option}={value}"]
                    if parameter.count == 1
                    else ([parameter.option, *[value] * parameter.count])
                )
            else:
                texts[place : place + 1] = [value]
            flags = ["--no-browser"] if command in BROWSING and parameter.name != "browser" else []
            words = [*command.split(), *(word for words in given.values() for word in words), *flags, "--", *texts]
            yield Line(command, parameter.name, parameter.kind, value, tuple(words))


def file_names(kind: type, base: str, help_text: str) -> tuple[str, ...]:
    """Return the hostile files for a parameter; none if it takes no path.

    base: a working value, "" if unknown. They have its suffix, or else the first one that the help names.
    """
    named = SUFFIX.fullmatch(base) or SUFFIX.search(help_text)
    is_path = kind is Path or (kind is str and (SUFFIX.fullmatch(base) or "file" in help_text.lower()))
    suffix = named[1] if named else ".yaml" if "YAML" in help_text else ".png" if "PNG" in help_text else ""
    return tuple(f"{name}{suffix}" for name in FILES) if is_path else ()


def _values(parameter: Parameter) -> tuple[str, ...]:
    if parameter.kind is bool:
        return ("",)
    return NUMBERS if parameter.kind in (int, float) else TEXTS


def prepare(folder: Path) -> None:
    """Write the files that BASES name."""
    from tests.fuzz.surveys import side_scan, survey, xtf_soundings

    from uwsim import Simulator, fly
    from uwsim.exercises.certified import digest_of
    from uwsim.recording import Recorder
    from uwsim.scenario.read.assets import assets_folder

    (folder / "folder").mkdir()
    (folder / "pool.yaml").write_bytes((assets_folder() / "scenarios" / "pool.yaml").read_bytes())
    surveyed = fly(None, "pool", map=True, mission_time_s=6.0, report="none").occupancy
    assert surveyed is not None
    surveyed.write(folder / "map.bt")
    (folder / "survey.gsf").write_bytes(survey(".gsf"))
    (folder / "survey.xtf").write_bytes(side_scan())
    (folder / "soundings.xtf").write_bytes(xtf_soundings())
    cells = [f"{500000 + x} {5000000 + y} {-8 - 0.1 * x}" for x in range(12) for y in range(12)]
    (folder / "sea.xyz").write_text("\n".join(cells))
    sim = Simulator("pool", seed=5)
    with Recorder(sim, folder / "run.mcap", topics=["odom", "imu*", "telemetry", "sonar_ping"]):
        sim.rov.release()
        sim.rov.set_effort(surge=0.4)
        sim.advance(1.0)
    (folder / "mission.py").write_text(
        "from uwsim.missions import wait\n\ndef mission(vehicle):\n    vehicle.release()\n    yield wait(1.0)\n"
    )
    sheet = {"person": "", "title": "Hover", "date": "2026-12-01T12:00:00+00:00"}
    (folder / "score.json").write_text(json.dumps({**sheet, "digest": digest_of(sheet)}))
    (folder / "sweep.yaml").write_text(
        "scenario: pool.yaml\nmission: mission.py\nvary: {survey.altitude_m: {choices: [1.5]}}\nworst: 0\n"
    )
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    cube = [*(f"v {x} {y} {z}" for x, y, z in corners), *(f"f {face}" for face in faces), ""]
    (folder / "cube.obj").write_text("\n".join(cube))
