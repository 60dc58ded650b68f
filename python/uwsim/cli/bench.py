"""`uwsim bench`: run one of the benchmarks."""

from __future__ import annotations

import ast
import inspect
import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from uwsim.cli.bounds import UsageError
from uwsim.cli.groups import show_help
from uwsim.cli.options import SETTINGS
from uwsim.cli.values import packaged_folder


class Benchmarks(TyperGroup):
    """One command per file in the benchmarks' folder; only the benchmark that runs is imported."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the benchmarks."""
        return sorted(path.stem for path in _folder().glob("*.py"))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a benchmark's command or, for help and shell completion, an outline that is quick to build."""
        path = _folder() / f"{cmd_name}.py"
        if not path.is_file():
            return None
        text = path.read_text()
        main = _outline(text) if ctx.resilient_parsing else runpy.run_path(str(path))["main"]
        program = typer.Typer(**SETTINGS)
        program.command(cmd_name, short_help=_first_line(text))(main)
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
    **SETTINGS,
)


def _folder() -> Path:
    return packaged_folder("bench", "tools/bench")


def _first_line(text: str) -> str:
    return text.removeprefix('"""').partition("\n")[0]


def _outline(text: str) -> Any:
    """Return an empty function with the options of a benchmark's `main`, all as text."""

    def main() -> None: ...

    found = dict(_options(text))
    parameters = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)
        for name, annotation in found.items()
    ]
    main.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    main.__annotations__ = found
    return main


def _options(text: str) -> Iterator[tuple[str, Any]]:
    head = re.search(r"^def main\(.*?\) -> None:", text, flags=re.DOTALL | re.MULTILINE)
    assert head, "a benchmark without a main"
    (function,) = ast.parse(f"{head[0]} ...").body
    assert isinstance(function, ast.FunctionDef)
    for argument in function.args.args:
        for call in ast.walk(argument):
            if isinstance(call, ast.Call) and ast.unparse(call.func) == "typer.Option":
                given = [str(each.value) for each in call.args if isinstance(each, ast.Constant)]
                yield argument.arg, Annotated[str | None, typer.Option(*given)]
