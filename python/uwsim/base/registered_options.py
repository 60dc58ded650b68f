"""The options of a socket's entries: each entry states its own, and a command has the flags of all of them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar

from uwsim.base.options import Flag, FlagGroup, OptionError, Options, flag_name, is_given
from uwsim.base.sockets import EntryError, SocketWarning, blamed, load_all, registered

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
