"""Options: settings that are also flags of commands. Type, default, help and rule are stated once, in a dataclass.

    @dataclass(frozen=True)
    class ToyOptions(Options):
        switch = "toy"

        toy: str | None = option(None, "Write readings to this file.", metavar="FILE")
        toy_rate: float | None = option(None, "Lines per second. Default: 10.", bounds=(0.1, 1000, "Hz"))

is the flags `--toy FILE` and `--toy-rate FLOAT`, of which the second needs the first. A unit at the end of a name, as
in toy_length_m, is left out of the flag: its help states it.
"""

from __future__ import annotations

import dataclasses
import re
import warnings
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar, get_type_hints

from uwsim.base.named import did_you_mean
from uwsim.base.sockets import EntryError, SocketWarning, blamed, load_all, registered


class OptionError(ValueError):
    """Raised for an option that cannot be used. exit_code: that of the command."""

    exit_code = 2


class WithoutEffectError(OptionError):
    """Raised for an option that would have no effect."""


@dataclasses.dataclass(frozen=True)
class Flag:
    """An option as a flag of a command.

    type: bool, int, float, str or Path (of a file to read), with None as a default; or tuple[str, ...] for a flag that
    may be repeated.
    choices: the accepted words, or () for any. bounds: lowest and highest accepted number, and the unit, or None.
    completion: the kind of packaged file that the shell completes, such as "modems". is_written: whether a Path is of a
    file or a folder to write.
    """

    type: Any
    default: Any
    help: str
    choices: tuple[str, ...] = ()
    bounds: tuple[float, float, str] | None = None
    metavar: str | None = None
    completion: str = ""
    is_written: bool = False


def option(default: Any, help: str, **settings: Any) -> Any:  # noqa: A002  # as in typer.Option
    """Return a field of Options. settings: the others of Flag, by name."""
    return dataclasses.field(default=default, metadata={"help": help, **settings})


class FlagGroup:
    """Values of several flags, by name. A command has the flags of each of its parameters that has this type."""

    def __init__(self, **values: Any) -> None:
        raise NotImplementedError

    @classmethod
    def flags(cls) -> Mapping[str, Flag]:
        """Return the flags by name, as in Python."""
        raise NotImplementedError


@dataclasses.dataclass(frozen=True)
class Options(FlagGroup):
    """The base of dataclasses whose fields are flags.

    switch: the name of the field without which the others have no effect, if there is one. Raises OptionError.
    """

    switch: ClassVar[str | None] = None

    def __post_init__(self) -> None:
        for name, flag in self.flags().items():
            _require(flag, name, getattr(self, name))
        if self.switch is not None and not self.is_requested:
            need(flag_name(self.switch), **self.given())

    def given(self) -> dict[str, bool]:
        """Return whether each option differs from its default."""
        return {each.name: getattr(self, each.name) != each.default for each in dataclasses.fields(self)}

    @property
    def arguments(self) -> dict[str, Any]:
        """The options that differ from their defaults, as keywords."""
        return {name: getattr(self, name) for name, is_given in self.given().items() if is_given}

    @property
    def is_requested(self) -> bool:
        """True if the switch is given, or if there is none."""
        return self.switch is None or is_given(getattr(self, self.switch))

    @classmethod
    def flags(cls) -> Mapping[str, Flag]:
        """Return the flags by field."""
        types = get_type_hints(cls)
        return {each.name: Flag(types[each.name], each.default, **each.metadata) for each in dataclasses.fields(cls)}


def flag_name(name: str) -> str:
    """Return the flag of an option, such as --ros-peer for ros_peer, and --time-limit for time_limit_s."""
    return "--" + re.sub(r"_(m|s|deg|mb)$", "", name).replace("_", "-")


def is_given(value: object) -> bool:
    """Return whether an option was passed: None, False and empty lists mean that it was not."""
    return value is not None and value is not False and value != [] and value != ()


def need(needed: str, **options: object) -> None:
    """Raise WithoutEffectError for options, by argument name, that were passed without another, such as "--record"."""
    count = sum(map(is_given, options.values()))
    refuse(f"{'need' if count > 1 else 'needs'} {needed}", **options)


def refuse(rule: str, **options: object) -> None:
    """Raise WithoutEffectError for options that were passed against a rule. options: values by argument name."""
    if given := [flag_name(name) for name, value in options.items() if is_given(value)]:
        raise WithoutEffectError(f"{', '.join(given)}: {rule}")


def require_within(name: str, number: float | None, low: float, high: float, unit: str = "") -> None:
    """Raise OptionError unless a number, if there is one, is in [low, high]; nan is refused."""
    if number is not None and not low <= number <= high:
        shown = f"{name} = {str(number)[:40]} {unit}".rstrip()
        raise OptionError(f"{shown}: must be in [{low:.12g}, {high:.12g}] {unit}".rstrip())


def require_one_of(name: str, word: str | None, known: tuple[str, ...]) -> None:
    """Raise OptionError unless a word, if there is one, is known."""
    if word is not None and word not in known:
        raise OptionError(f"{name} = '{word[:40]}': must be one of {', '.join(known)}{did_you_mean(word, known)}")


def _require(flag: Flag, name: str, value: Any) -> None:
    for each in value if isinstance(value, tuple) else (value,):
        if flag.choices:
            require_one_of(flag_name(name), each, flag.choices)
        if flag.bounds is not None:
            require_within(flag_name(name), each, *flag.bounds)


def named_numbers(option: str, text: str, limits: Mapping[str, tuple[float, float, str]]) -> dict[str, float]:
    """Return the numbers in a text by name. limits: lowest, highest and unit by name.

    Raises ValueError, which names the option and the key, for an unknown or repeated name, or a number that is out of
    its limits.
    """
    values: dict[str, float] = {}
    for part in text.split(","):
        name, equals, number = (each.strip() for each in part.partition("="))
        if not equals or name not in limits or name in values:
            names, example = ", ".join(limits), next(iter(limits))
            raise ValueError(f"{option} '{part.strip()}': must be one of {names}, each once, as {example}=0.5")
        low, high, unit = limits[name]
        try:
            values[name] = float(number)
        except ValueError:
            raise ValueError(f"{option} {name}={number}: must be a number in {unit}") from None
        if not low <= values[name] <= high:  # false for nan, too
            raise ValueError(f"{option} {name}={number} {unit}: must be in [{low:g}, {high:g}] {unit}")
    return values


OptionsT = TypeVar("OptionsT", bound=Options)


class RegisteredOptions(FlagGroup, Generic[OptionsT]):
    """The options of all entries of a socket, which are classes of options. Raises OptionError.

    socket: the group of entry points. base: the class from which its entries are derived. is_switched: whether each
    has a switch. requested: the options whose switch is given, or that have none, by their entry's name.
    """

    socket: ClassVar[str]
    base: ClassVar[type[Options]]
    is_switched: ClassVar[bool] = True

    def __init__(self, **values: Any) -> None:
        self.requested: dict[str, OptionsT] = {}
        for name, kind in self.offered().items():
            options = self._made(name, kind, {each: values.pop(each) for each in kind.flags() if each in values})
            if options is not None and options.is_requested:
                self.requested[name] = options
        if values:
            raise TypeError(f"{', '.join(values)}: nothing that is registered has this option")

    def _made(self, name: str, kind: type[OptionsT], values: Mapping[str, Any]) -> OptionsT | None:
        """Return an entry's options. Another package's whose class raises an error is used only by who asks for it."""
        entry = registered(self.socket)[name]
        try:
            return kind(**values)
        except Exception as error:
            if isinstance(error, OptionError) or entry.is_own:
                raise
            what = blamed(self.socket, entry, error, "options")
            if any(map(is_given, values.values())):
                raise EntryError(what) from error
            warnings.warn(what, SocketWarning, stacklevel=2)
            return None

    @classmethod
    def offered(cls) -> Mapping[str, type[OptionsT]]:
        """Return the classes of options by entry. Warns with SocketWarning of those that do not fit."""
        return load_all(cls.socket, cls._fitting)

    @classmethod
    def _fitting(cls, name: str, found: Any) -> type[OptionsT]:
        if not (isinstance(found, type) and issubclass(found, cls.base)):
            raise TypeError(f"must be a class derived from {cls.base.__name__}")
        require_named(cls.socket, name, found, cls.is_switched)
        return found  # type: ignore[return-value]  # derived from `base`

    @classmethod
    def flags(cls) -> Mapping[str, Flag]:
        """Return the flags of all entries."""
        return {name: flag for kind in cls.offered().values() for name, flag in kind.flags().items()}

    @property
    def only(self) -> OptionsT | None:
        """The one that is requested, if any. Raises OptionError for two."""
        if len(self.requested) > 1:
            first, second, *_ = self.requested
            raise OptionError(f"{flag_name(second)}: cannot be given with {flag_name(first)}")
        return next(iter(self.requested.values()), None)


def require_named(group: str, name: str, options: type[Options], is_switched: bool = True) -> None:
    """Raise ValueError unless options are named as the entry is registered; uwsim's own need only its switch."""
    if options.switch != name and (is_switched or options.switch is not None):
        raise ValueError(f"switch = {options.switch!r}: must be {name!r}, as it is registered")
    if not registered(group)[name].is_own:
        for flag in options.flags():
            if flag != name and not flag.startswith(f"{name}_"):
                raise ValueError(f"option {flag}: its name must begin with {name}_")
