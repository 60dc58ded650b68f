"""The commands that are registered, their headings in `uwsim --help`, and commands with subcommands."""

from __future__ import annotations

import inspect
import signal
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

from uwsim.base.sockets import blaming, is_offered, load, load_all, registered
from uwsim.cli.flags import expanded
from uwsim.cli.options import SETTINGS
from uwsim.cli.scenario_word import with_both_spellings
from uwsim.cli.signals import exit_interrupted

SOCKET = "uwsim.cli"
"""The group of entry points for commands: functions, as for `typer.Typer.command`, and `typer.Typer` for groups.

Those of some commands with subcommands are groups, too: `uwsim.cli.map` and `uwsim.cli.scenario`.
"""
OTHERS = "From other packages"
"""The heading of commands that give none."""

ENDS = (OSError, ValueError, typer.BadParameter.__bases__[0], typer.Exit, typer.Abort)
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
        self.commands = _Commands()  # type: ignore[assignment]  # read, never written

    def invoke(self, ctx: Any) -> Any:
        """Run the command. Ctrl-C that it does not handle ends the process with a line; typer would not print one."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            exit_interrupted(signal.SIGINT, None)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names; typer would build all commands for them, whenever a word is completed."""
        return list(self.commands)

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


class _Commands(Mapping[str, Any]):
    """The registered commands by name, built when they are read. Raises ValueError for one that cannot be used."""

    def __getitem__(self, name: str) -> Any:
        if name not in registered(SOCKET):
            raise KeyError(name)
        return load(SOCKET, name, _command)

    def __iter__(self) -> Iterator[str]:
        return iter(registered(SOCKET))

    def __len__(self) -> int:
        return len(registered(SOCKET))


def _command(name: str, found: Any) -> Any:
    """Return typer's command or group of what is registered under a name. Raises TypeError."""
    program = typer.Typer(**SETTINGS)
    if isinstance(found, typer.Typer):
        known = {each.name for each in found.registered_commands}
        more = load_all(f"{SOCKET}.{name}", _function) if is_offered(f"{SOCKET}.{name}") else {}
        for subcommand in [each for each in more if each not in known]:
            found.command(subcommand)(expanded(more[subcommand]))
        program.add_typer(found, name=name, rich_help_panel=found.rich_help_panel)
    elif inspect.isfunction(found):
        program.command(name)(expanded(found))
    else:
        raise TypeError(f"{type(found).__name__}: must be a function or a typer.Typer")
    made = with_both_spellings(typer.main.get_group(program).commands[name])
    made.invoke = partial(_invoked, name, made.invoke)
    return made


def _invoked(name: str, invoke: Callable[..., Any], *context: Any) -> Any:
    with blaming(SOCKET, name, "command", ENDS):
        return invoke(*context)


def _function(name: str, found: Any) -> Callable[..., Any]:
    """Return a subcommand. Raises TypeError, or RuntimeError for parameters of which typer cannot make options."""
    if not inspect.isfunction(found):
        raise TypeError(f"{type(found).__name__}: must be a function")
    if not found.__module__.startswith("uwsim."):  # one that is refused later would take the whole group with it
        _command(name, found)
    return found


def _outline(name: str, found: Any) -> Any:
    """Return a command as --help of the program lists it: without options, since building those takes longest."""
    if not inspect.isfunction(found):
        return _command(name, found)
    return TyperCommand(name, help=inspect.getdoc(found), rich_help_panel=getattr(found, "rich_help_panel", None))


def show_help(context: typer.Context) -> None:
    """Print a group's help if it is called without a subcommand; the callback of its typer program."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
