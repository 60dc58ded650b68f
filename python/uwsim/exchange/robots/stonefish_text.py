"""Texts of Stonefish's scenarios: formulas, arguments, and where the files are that they name.

Source: Stonefish 1.6, ScenarioParser and its tinyexpr; stonefish_ros, ROSScenarioParser.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from uwsim.exchange.robots.sources import package_folder

DATA = ("", "data", "resources", "share", "assets")
"""Folders of data, in those above a file."""
ARGUMENT = re.compile(r"\$\((\w+)\s*([^()]*)\)")
FORMULA = re.compile(r"\$\{([^}]*)\}")
WORD = re.compile(r"\s*((?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[A-Za-z]\w*|\S)")
CONSTANTS = {"pi": math.pi, "e": math.e}
LEVELS: tuple[dict[str, Callable[[float, float], float]], ...] = (
    {"+": lambda a, b: a + b, "-": lambda a, b: a - b},
    {"*": lambda a, b: a * b, "/": lambda a, b: a / b, "%": math.fmod},
    {"^": math.pow},  # from the left
)
OF_MATH = "acos asin atan ceil cos cosh exp floor log10 sin sinh sqrt tan tanh"
FUNCTIONS: dict[str, Callable[[float], float]] = {name: getattr(math, name) for name in OF_MATH.split()} | {
    "abs": abs,
    "ln": math.log,
    "log": math.log10,
    "fac": lambda n: math.gamma(math.floor(n) + 1.0),
}
FUNCTIONS_OF_TWO: dict[str, Callable[[float, float], float]] = {
    "atan2": math.atan2,
    "pow": math.pow,
    "npr": lambda n, r: FUNCTIONS["fac"](n) / FUNCTIONS["fac"](n - r),
    "ncr": lambda n, r: FUNCTIONS["fac"](n) / FUNCTIONS["fac"](n - r) / FUNCTIONS["fac"](r),
}


def formula(text: str) -> float:
    """Return the value of a formula of numbers, constants, functions, + - * / % ^ and parentheses. Raises ValueError.

    As in tinyexpr, a sign binds closer than ^, which goes from left to right, and log is that to base 10.
    """
    words = WORD.findall(text)[::-1]

    def took(*ones: str) -> str | None:
        return words.pop() if words and words[-1] in ones else None

    def need(one: str) -> None:
        if took(one) is None:
            raise ValueError

    def within() -> float:
        value = level(0)
        need(")")
        return value

    def level(of: int) -> float:
        if of == len(LEVELS):
            return signed()
        value = level(of + 1)
        while (sign := took(*LEVELS[of])) is not None:
            value = LEVELS[of][sign](value, level(of + 1))
        return value

    def signed() -> float:
        sign = 1.0
        while (each := took("+", "-")) is not None:
            sign = -sign if each == "-" else sign
        return sign * term(words.pop())

    def term(word: str) -> float:
        if word == "(":
            return within()
        if word in FUNCTIONS:
            return FUNCTIONS[word](signed())
        if word in FUNCTIONS_OF_TWO:
            need("(")
            first = level(0)
            need(",")
            return FUNCTIONS_OF_TWO[word](first, within())
        if word in CONSTANTS:
            if took("("):
                need(")")
            return CONSTANTS[word]
        if word[0].isalpha():
            raise ValueError
        return float(word)

    try:
        value = level(0)
        if words or not math.isfinite(value):
            raise ValueError
    except (ValueError, IndexError, ArithmeticError, RecursionError):
        rule = "must consist of numbers, pi, functions, + - * / % ^ and parentheses"
        raise ValueError(f"formula {text[:60]!r}: {rule}") from None
    return value


class Texts:
    """The values of the arguments, packages and formulas of a scenario and of the files that it includes.

    given: the arguments that a user states, by name. missing: those without a value, with the file that needs each.
    """

    def __init__(self, given: Mapping[str, str]) -> None:
        self._given = given
        self.missing: dict[str, Path] = {}

    def expanded(self, text: str, path: Path, own: Mapping[str, str]) -> str:
        """Return a text of a file. own: the arguments of its include. Raises ValueError for a bad formula or name.

        What has no value stays as it is: a package, since many name only topics; an argument is then missing.
        """

        def argument(match: re.Match[str]) -> str:
            word, name = match[1], match[2].strip()
            if word == "find":
                return str(package_folder(name, path) or match[0])
            values = {"arg": {**self._given, **own}, "param": self._given}.get(word)
            if values is None:
                raise ValueError(f"'{path}': {match[0]}: must be $(arg NAME), $(param NAME) or $(find PACKAGE)")
            name = name.lstrip("~/")
            if name not in values:
                self.missing.setdefault(name, path)
            return values.get(name, match[0])

        def value(match: re.Match[str]) -> str:
            if "$(" in match[1]:
                return match[0]
            try:
                return repr(formula(match[1]))
            except ValueError as error:
                raise ValueError(f"'{path}': {error}") from None

        return FORMULA.sub(value, ARGUMENT.sub(argument, text))

    def require_all(self) -> None:
        """Raise ValueError if an argument is missing."""
        if self.missing:
            names = " ".join(f"--arg {name}=VALUE" for name in self.missing)
            raise ValueError(f"'{next(iter(self.missing.values()))}': has arguments without a value: give {names}")


def file_named(name: str, files: tuple[Path, ...], data: Path | None) -> Path:
    """Return the file of a name: in the given folder of data, else in the nearest folder above one of some files.

    Of a package that is nowhere, the rest of the name is looked for. Raises ValueError.
    """
    rest = re.sub(r"^\$\(find [^)]*\)/*", "", name)

    def folders() -> Iterator[Path]:
        if data is not None:
            yield data
        for file in files:
            for folder in file.resolve().parents:
                yield from (folder / each for each in DATA)

    path = next((folder / rest for folder in folders() if (folder / rest).is_file()), None)
    if path is None:
        where = f"above '{files[0]}', nor in their {', '.join(DATA[1:])}"
        raise ValueError(f"'{name}': is in no folder {where}: --data FOLDER names that of Stonefish's data")
    return path
