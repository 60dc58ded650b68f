"""Sealed: a base class whose instances reject assignments that would have no effect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

from uwsim.base.named import Named, did_you_mean


class Sealed:
    """Base for classes whose public attributes cannot be changed once an object has been created.

    A subclass declares its attributes (`name: str`) and sets each once. Properties with a setter can be assigned. Any
    other assignment raises AttributeError, which names the closest attribute or the method that changes the value. So
    does reading an unknown attribute, for which the names of parts (`Named`) are known as well.
    """

    _fixed_when: ClassVar[str] = "the simulator is made"
    _changed_by: ClassVar[Mapping[str, str]] = {}
    """The method that changes each attribute, such as {"effort": "set_effort()"}."""
    _meant: ClassVar[Mapping[str, str]] = {}
    """The part that a name means which others use, such as {"save": "save_state()"}."""
    _declared: ClassVar[frozenset[str]] = frozenset()
    _assignable: ClassVar[frozenset[str]] = frozenset()

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls._declared |= vars(cls).get("__annotations__", {}).keys()
        cls._assignable |= {name for name, part in vars(cls).items() if isinstance(part, property) and part.fset}

    def __setattr__(self, name: str, value: Any) -> None:
        if name[:1] == "_" or name in self._assignable or (name in self._declared and name not in self.__dict__):
            object.__setattr__(self, name, value)
        else:
            raise AttributeError(self._refusal(name))

    if not TYPE_CHECKING:  # mypy would then accept any attribute

        def __getattr__(self, name: str) -> Any:
            if name[:1] == "_" or hasattr(type(self), name):  # a property whose own code lacks an attribute
                return object.__getattribute__(self, name)
            raise UnknownAttributeError(self, name)

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__}.{name}: cannot be deleted")

    def _refusal(self, name: str) -> str:
        owner = type(self)
        attribute = f"{owner.__name__}.{name}"
        known = owner._known()
        if name not in known:
            return f"{attribute}: unknown attribute{owner._hint(name, known)}"
        if name in owner._changed_by:
            return f"{attribute}: cannot be assigned; use {owner._changed_by[name]}"
        if callable(getattr(owner, name, None)):
            return f"{attribute}: cannot be assigned; it is a method: call it"
        return f"{attribute}: cannot be assigned; it is fixed when {owner._fixed_when}"

    @classmethod
    def _hint(cls, name: str, known: Iterable[str], written: Mapping[str, str] | None = None) -> str:
        meant = cls._meant.get(name.lower())
        return f"; did you mean {meant}?" if meant else did_you_mean(name, known, written)

    @classmethod
    def _known(cls) -> set[str]:
        return {each for each in (*dir(cls), *cls._declared) if not each.startswith("_")}


class UnknownAttributeError(AttributeError):
    """Raised where a Sealed object has no such attribute. Its text takes a search, which `hasattr` need not pay for."""

    def __init__(self, owner: Sealed, name: str) -> None:
        super().__init__(name)
        self._owner = owner
        self._name = name

    def __reduce__(self) -> tuple[type[AttributeError], tuple[str]]:
        return AttributeError, (str(self),)  # without the object, which may not travel

    def __str__(self) -> str:
        known = self._owner._known()
        parts = {each: held for each, held in vars(self._owner).items() if isinstance(held, Named)}
        items = {item: f"{part}['{item}']" for part, held in reversed(parts.items()) for item in held}
        written = {item: path for item, path in items.items() if item not in known}
        hint = self._owner._hint(self._name, {*known, *written}, written)
        return f"{type(self._owner).__name__}.{self._name}: unknown attribute{hint}"


class Attached(Sealed):
    """Base for Sealed objects that are part of a running simulator, and therefore cannot be copied or pickled."""

    _copied_by: ClassVar[str] = "keep the values that it returns, or transfer its simulator's save_state()"
    """Advice, shown to a user who tries."""

    def __copy__(self) -> NoReturn:
        raise TypeError(f"a {type(self).__name__} cannot be copied or pickled: {self._copied_by}")

    def __deepcopy__(self, memo: object) -> NoReturn:
        self.__copy__()

    def __reduce__(self) -> NoReturn:
        self.__copy__()
