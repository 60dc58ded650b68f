"""Imports missions from Python files, and reports their errors by file and line."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Callable, Mapping
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

from uwsim.base.named import did_you_mean
from uwsim.missions.run import MissionFunction, first_parameter
from uwsim.missions.unrun_steps import require_steps_run

FUNCTION = "mission"


class MissionError(ValueError):
    """An error in a mission. If the mission is in a file, the message names the file and line."""


def load_mission(path: str | Path, function: str = FUNCTION) -> MissionFunction:
    """Import a file and return its mission, the function with this name.

    Raises MissionError if the file has no usable mission, OSError if it cannot be read.
    """
    file = Path(path)
    if not file.is_file():
        raise MissionError(f"mission '{path}': no such file")
    if file.suffix != ".py":
        raise MissionError(
            f"mission '{path}': must be a Python file, *.py, or a file of the field: a QGroundControl plan, "
            "QGC WPL 110, GeoJSON, KML"
        )
    module = _module(file)
    if not callable(found := getattr(module, function, None)):
        known = [name for name, value in vars(module).items() if callable(value) and not name.startswith("_")]
        hint = did_you_mean(function, known) or ": write `def mission(vehicle): yield wait(1.0)`"
        raise MissionError(f"{path}: has no function '{function}'{hint}")
    try:
        first_parameter(found)
    except ValueError as error:
        code = getattr(found, "__code__", None)  # classes have no __code__
        raise MissionError(f"{path}{f':{code.co_firstlineno}' if code else ''}: {error}") from None
    try:
        require_steps_run(found)
    except ValueError as error:
        raise MissionError(str(error).replace(str(file.resolve()), str(path), 1)) from None
    return found  # type: ignore[no-any-return]


def with_arguments(mission: MissionFunction, arguments: Mapping[str, Any]) -> MissionFunction:
    """Bind values to the mission's other parameters. Raises MissionError for an unknown parameter."""
    if not arguments:
        return mission
    known = [p.name for p in list(signature(mission).parameters.values())[1:]]
    for name in arguments:
        if name not in known:
            rule = f"must be one of {', '.join(known)}" if known else "the mission has none"
            raise MissionError(f"mission argument '{name}': {rule}{did_you_mean(name, known)}")
    return partial(mission, **arguments)


def mission_name(mission: MissionFunction, file: Path | None) -> str:
    """Return the name of a mission for reports: that of its file or, without one, its function."""
    if file is not None:
        return file.name
    function = mission.func if isinstance(mission, partial) else mission
    return str(getattr(function, "__name__", "mission"))


def _module(file: Path) -> Any:
    """Import a file as a module; as in a script, it can import modules from its own folder."""
    spec = importlib.util.spec_from_file_location(file.stem, file.resolve())
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    before = sys.modules.get(file.stem)
    sys.modules[file.stem] = module
    sys.path.insert(0, str(file.resolve().parent))
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        where = file if error.filename in (None, str(file.resolve())) else error.filename
        line = "" if error.lineno is None else f":{error.lineno}"
        raise MissionError(f"{where}{line}: {error.msg}") from None
    except Exception as error:
        raise mission_error(error, file) from None
    finally:
        sys.path.remove(str(file.resolve().parent))
        if before is not None:
            sys.modules[file.stem] = before
    return module


def mission_error(error: BaseException, file: Path) -> MissionError:
    """Return a one-line error that names the line of the mission file where the original error occurred."""
    folder = str(file.resolve().parent)
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if frame.filename == str(file.resolve())]
    own = own or [frame for frame in frames if frame.filename.startswith(folder)]
    text = str(error) if isinstance(error, ValueError | MissionError) and str(error) else _named(error)
    where = f"{file}:{own[-1].lineno}" if own else str(file)
    inside = f" (in {own[-1].name})" if own and own[-1].name != "<module>" else ""
    return MissionError(f"{where}: {text}{inside}")


def _named(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


def parsed_arguments(texts: list[str], parse: Callable[[str], Any]) -> dict[str, Any]:
    """Parse strings NAME=VALUE; return the values by name. A value that `parse` rejects is kept as a string.

    Raises MissionError if a string does not have this form.
    """
    arguments = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise MissionError(f"--set {text}: must be NAME=VALUE")
        try:
            arguments[name] = parse(value)
        except (ValueError, SyntaxError):
            arguments[name] = value
    return arguments
