"""The commands that are registered, their headings in `uwsim --help`, and commands with subcommands."""

from __future__ import annotations

import inspect
import signal
from collections.abc import Callable, ItemsView, Iterator, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

from uwsim.base.named import did_you_mean
from uwsim.base.sockets import blaming, is_offered, load, load_all, registered
from uwsim.cli.exit_codes import FAILED, exit_interrupted
from uwsim.cli.flags import expanded
from uwsim.cli.options import SETTINGS

SOCKET = "uwsim.cli"
"""The group of entry points for commands: functions, as for `typer.Typer.command`, and `typer.Typer` for groups.

Those of some commands with subcommands are groups, too, such as `uwsim.cli.map` and `uwsim.cli.vehicle`.
"""
GONE = {
    "rays": "scenario rays",
    "connect": "ros connect",
    "doctor": "ros doctor",
    "diff": "recording diff",
    "tune": "vehicle tune",
    "parameters": "scenario parameters",
    "decompose": "vehicle decompose",
    "identify": "vehicle identify",
    "fingerprint": "scenario fingerprint",
    "sonar": "scenario sonar",
    "camera": "scenario camera",
    "film": "recording film",
    "range": "docs/notebooks/sight.ipynb",
}
"""Spellings of up to 0.3, and what is there instead: a command, or a notebook."""
OTHERS = "From other packages"
"""The heading of commands that give none."""

MEANT = "uwsim.meant"
"""The key of a suggestion in a context's `meta`: of a subcommand, for errors about the first word of a group."""

USAGE_ERROR: Any = typer.BadParameter.__bases__[0]
ENDS: tuple[type[Exception], ...] = (OSError, ValueError, USAGE_ERROR, typer.Exit, typer.Abort)
"""The errors with which a command may end, any usage error included."""

F = TypeVar("F", bound=Callable[..., Any])


def under(heading: str) -> Callable[[F], F]:
    """List a command under this heading of `uwsim --help`. For a group: typer.Typer(rich_help_panel=heading)."""

    def mark(command: F) -> F:
        command.rich_help_panel = heading  # type: ignore[attr-defined]
        return command

    return mark


class Program(TyperGroup):
    """The program: each registered command is imported when it is used, and all of them for --help."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = _Commands(SOCKET)  # type: ignore[assignment]  # read, never written

    def invoke(self, ctx: Any) -> Any:
        """Run the command. Ctrl-C that it does not handle ends the process with a line; typer would not print one."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            exit_interrupted(signal.SIGINT, None)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names; typer would build all commands for them, whenever a word is completed."""
        return list(self.commands)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, command and arguments. Raises a usage error; of one that is gone, it names the present one."""
        if (old := args[0]) in GONE and old not in self.commands:
            now = GONE[old] if GONE[old].startswith("docs/") else f"uwsim {GONE[old]}"
            raise USAGE_ERROR(f"No such command '{old}': it is '{now}' now", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands by heading, all aligned in the same columns.

        Typer shows headings only in its markup mode, which would swallow units in brackets.
        """
        shown = {name: each for name, each in load_all(SOCKET, _outline).items() if not each.hidden}
        width = max(map(len, shown))
        for heading in dict.fromkeys(_heading(each) for each in shown.values()):
            rows = [
                (name.ljust(width), each.get_short_help_str(formatter.width - width - 6))
                for name, each in shown.items()
                if _heading(each) == heading
            ]
            with formatter.section(heading):
                formatter.write_dl(rows)


def _heading(outline: Any) -> str:
    return outline.rich_help_panel or OTHERS


class WithDefault(TyperGroup):
    """A group whose first subcommand runs if the first word is none of its subcommands."""

    def spelled_out(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the words with the subcommand that they are for, unless they ask for the group's help."""
        if args and args[0] in (*self.commands, *ctx.help_option_names):
            return args
        return [next(iter(self.commands)), *args]

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words. A shell that asks for the first one is offered subcommands, too."""
        if args or not ctx.resilient_parsing:
            ctx.meta[MEANT] = self._meant(ctx.command_path, args)
            args = self.spelled_out(ctx, args)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the subcommand. An error about a word that resembles a subcommand states that one, too."""
        meant = ctx.meta[MEANT]
        try:
            return super().invoke(ctx)
        except typer.Exit as end:
            if meant and end.exit_code == FAILED:
                typer.echo(f"uwsim:{meant.removeprefix(';')}", err=True)
            raise
        except ENDS as error:
            if meant:
                error.add_note(meant)
            raise

    def _meant(self, path: str, args: list[str]) -> str:
        """Return the suggestion of the subcommand that the first word resembles, "" if it is a file or resembles none.

        path: the words before it.
        """
        if not args or args[0] in self.commands or args[0].startswith("-") or Path(args[0]).exists():
            return ""
        return did_you_mean(args[0], self.commands, {each: f"'{path} {each}'" for each in self.commands})

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the default's help as that of the group, and the subcommands."""
        default = next(iter(self.commands.values()))
        default.format_help(type(ctx)(default, info_name=ctx.info_name, parent=ctx.parent), formatter)
        self.format_commands(ctx, formatter)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the subcommands below a heading that names the default."""
        shown = dict(self.commands.items())
        limit = formatter.width - 6 - max(map(len, shown))
        with formatter.section(f"Commands (without one: {next(iter(shown))})"):
            formatter.write_dl([(name, each.get_short_help_str(limit)) for name, each in shown.items()])

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        """Return completions of a subcommand, or of the default's first word or its options."""
        name, default = next(iter(self.commands.items()))
        alone = default.make_context(name, [], parent=ctx, resilient_parsing=True)
        if incomplete.startswith("-"):
            return default.shell_complete(alone, incomplete)
        words = (each for each in default.params if each.param_type_name == "argument")
        return [*super().shell_complete(ctx, incomplete), *next(words).shell_complete(alone, incomplete)]


def with_default(name: str, about: str, heading: str) -> typer.Typer:
    """Return a group whose first command is its default. about: its line in `uwsim --help`, under the heading."""
    return typer.Typer(name=f"uwsim {name}", cls=WithDefault, help=about, rich_help_panel=heading, **SETTINGS)


class _Commands(Mapping[str, Any]):
    """The commands of a group by name: those that it has built, and those of a socket, which are built when read.

    Raises ValueError for one that cannot be used; the view of all warns of those and leaves them out.
    """

    def __init__(self, socket: str, built: Mapping[str, Any] = MappingProxyType({})) -> None:
        self._socket, self._built, self._make = socket, built, partial(_command, socket)

    def __getitem__(self, name: str) -> Any:
        if name not in self:
            raise KeyError(name)
        return self._built[name] if name in self._built else load(self._socket, name, self._make)

    def __contains__(self, name: object) -> bool:
        return name in self._built or name in registered(self._socket)

    def __iter__(self) -> Iterator[str]:
        return iter({**self._built, **registered(self._socket)})

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def items(self) -> ItemsView[str, Any]:
        """Return the names and commands of all that can be used."""
        return {**self._built, **load_all(self._socket, self._make), **self._built}.items()


def _command(socket: str, name: str, found: Any) -> Any:
    """Return typer's command or group of what is registered under a name. Raises TypeError."""
    program = typer.Typer(**SETTINGS)
    if inspect.isfunction(found):
        program.command(name)(expanded(found))
    elif socket != SOCKET:
        raise TypeError(f"{type(found).__name__}: must be a function")
    elif isinstance(found, typer.Typer):
        for each in found.registered_commands:
            each.callback = each.callback and expanded(each.callback)
        program.add_typer(found, name=name, rich_help_panel=found.rich_help_panel)
    else:
        raise TypeError(f"{type(found).__name__}: must be a function or a typer.Typer")
    made: Any = typer.main.get_group(program).commands[name]
    if is_offered(f"{socket}.{name}"):
        made.commands = _Commands(f"{socket}.{name}", made.commands)
    made.invoke = partial(_invoked, socket, name, made.invoke)
    return made


def _invoked(socket: str, name: str, invoke: Callable[..., Any], *context: Any) -> Any:
    with blaming(socket, name, "command", ENDS):
        return invoke(*context)


def _outline(name: str, found: Any) -> Any:
    """Return a command as --help of the program lists it: without options, since building those takes longest."""
    if not inspect.isfunction(found):
        if not (isinstance(found, typer.Typer) and registered(SOCKET)[name].is_own):
            return _command(SOCKET, name, found)  # one that cannot be used is not listed
        about, short = found.info.help or "", found.info.short_help or None
        return TyperCommand(name, help=about, short_help=short, rich_help_panel=found.rich_help_panel)
    return TyperCommand(name, help=inspect.getdoc(found), rich_help_panel=getattr(found, "rich_help_panel", None))


def show_help(context: typer.Context) -> None:
    """Print a group's help if it is called without a subcommand; the callback of its typer program."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
