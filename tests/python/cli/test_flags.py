"""Flags from classes of options: a command gets an object of the class, checked."""

import inspect
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest
import typer

from uwsim.base.options import OptionError, Options, option
from uwsim.base.sockets import SocketWarning
from uwsim.cli.flags import expanded


@dataclass(frozen=True)
class Rig(Options):
    rig_part: tuple[str, ...] = option((), "A part; may be repeated.", choices=("arm", "leg"))
    rig_plan: Path | None = option(None, "Its plan.")


@dataclass(frozen=True)
class Speed(Options):
    speed: float = option(1.0, "Simulated seconds per wall second.")
    speed_max: float = option(9.0, "The highest.")


def fly(*, rig: Rig, speed: Annotated[str, typer.Option(help="The pace.")] = "1") -> tuple[Rig, str]:
    return rig, speed


def plain(speed: float = 1.0) -> None: ...


def test_a_class_of_options_stands_for_its_flags() -> None:
    command = expanded(fly)
    assert list(inspect.signature(command).parameters) == ["rig_part", "rig_plan", "speed"]
    assert command(rig_part=["arm", "leg"], rig_plan=None, speed="2") == (Rig(rig_part=("arm", "leg")), "2")
    assert command(rig_part=None, rig_plan=None, speed="1") == (Rig(), "1")
    with pytest.raises(OptionError, match="--rig-part = 'tail': must be one of arm, leg"):
        command(rig_part=["arm", "tail"], rig_plan=None, speed="1")
    assert expanded(plain) is plain, "it has none"


def test_of_flags_with_one_name_the_commands_own_is_kept() -> None:
    def run(*, more: Speed, speed: Annotated[str, typer.Option(help="The pace.")] = "1") -> tuple[Speed, str]:
        return more, speed

    with pytest.warns(SocketWarning, match="--speed: another option has this name"):
        command = expanded(run)
    assert command(speed="max", speed_max=5.0) == (Speed(speed_max=5.0), "max")
