"""`uwsim bench`: run one of the benchmarks."""

from __future__ import annotations

import ast
import inspect
import json
import re
import runpy
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.cli.groups import show_help
from uwsim.cli.options import SETTINGS
from uwsim.cli.values import UsageError, packaged_folder

JsonFile = Annotated[Path | None, typer.Option("--json", help="Also write the values to this file.")]


class Benchmarks(TyperGroup):
    """One command per file in the benchmarks' folder; only the benchmark that runs is imported."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the benchmarks."""
        return sorted(path.stem for path in _folder().glob("[!_]*.py"))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a benchmark's command or, for help and shell completion, an outline that is quick to build."""
        path = _folder() / f"{cmd_name}.py"
        if not path.is_file():
            return None
        text = path.read_text()
        program = typer.Typer(**SETTINGS)
        command = _outline(text) if ctx.resilient_parsing else _command(path)
        program.command(cmd_name, short_help=_first_line(text))(command)
        return typer.main.get_command(program)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, command and arguments. Raises UsageError, listing the benchmarks."""
        if not ctx.resilient_parsing and args[0] not in (known := self.list_commands(ctx)):
            raise UsageError(f"benchmark '{args[0]}': unknown; there are: {', '.join(known)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the benchmarks with the first lines of their docstrings."""
        with formatter.section("Benchmarks"):
            formatter.write_dl(
                [(name, _first_line((_folder() / f"{name}.py").read_text())) for name in self.list_commands(ctx)]
            )


app = typer.Typer(
    name="uwsim bench",
    cls=Benchmarks,
    help="Run a benchmark; print medians and where the time is spent.\n\n`uwsim bench NAME --help` lists its options.",
    invoke_without_command=True,
    callback=show_help,
    subcommand_metavar="NAME [ARGS]...",
    rich_help_panel="Check",
    **SETTINGS,
)


def _folder() -> Path:
    return packaged_folder("bench", "tools/bench")


def _first_line(text: str) -> str:
    return text.removeprefix('"""').partition("\n")[0]


def _command(path: Path) -> Callable[..., None]:
    """Return a benchmark's `main` as a command, with an option --json for the values that it returns."""
    sys.path.append(str(path.parent))  # the benchmarks share a module
    main = runpy.run_path(str(path))["main"]
    options = {name: each.annotation for name, each in inspect.signature(main, eval_str=True).parameters.items()}

    def run(json_file: Path | None, **given: Any) -> None:
        for file in filter(None, (json_file, given.get("plot"))):
            require_own(file)  # now, since a benchmark takes minutes
        figures = main(**given)
        if json_file is not None:
            write_atomically(json_file, (json.dumps(figures, indent=2) + "\n").encode())

    run.__doc__ = main.__doc__
    defaults = {name: each.default for name, each in inspect.signature(main).parameters.items()}
    return _with_options(run, options | {"json_file": JsonFile}, defaults)


def _outline(text: str) -> Callable[..., None]:
    """Return an empty function with the options of a benchmark, all as text."""

    def main() -> None: ...

    return _with_options(main, dict(_options(text)) | {"json_file": Annotated[str | None, typer.Option("--json")]}, {})


def _with_options(
    function: Callable[..., None], options: Mapping[str, Any], defaults: Mapping[str, Any]
) -> Callable[..., None]:
    parameters = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=defaults.get(name), annotation=annotation)
        for name, annotation in options.items()
    ]
    function.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    function.__annotations__ = dict(options)
    return function


def _options(text: str) -> Iterator[tuple[str, Any]]:
    head = re.search(r"^def main\(.*?\) -> ", text, flags=re.DOTALL | re.MULTILINE)
    assert head, "a benchmark without a main"
    (function,) = ast.parse(f"{head[0]}None: ...").body
    assert isinstance(function, ast.FunctionDef)
    for argument in function.args.args:
        calls = {ast.unparse(call.func): call for call in ast.walk(argument) if isinstance(call, ast.Call)}
        if "typer.Argument" not in calls:
            option = calls.get("typer.Option")  # none where the harness has the type
            given = [str(each.value) for each in option.args if isinstance(each, ast.Constant)] if option else []
            yield argument.arg, Annotated[str | None, typer.Option(*given)]
