"""Options and arguments that accept one of a fixed set of words, which is checked early and completed by the shell."""

from __future__ import annotations

from typing import Any

import typer

from uwsim.base.options import require_one_of
from uwsim.cli.bounds import option_name
from uwsim.cli.values import words


def one_of(*known: str) -> dict[str, Any]:
    """Return typer's settings for a parameter that accepts one or several of these words."""

    def check(param: typer.CallbackParam, value: Any) -> Any:
        for word in value if isinstance(value, list) else (value,):
            require_one_of(option_name(param), word, known)
        return value

    return {"callback": check, "autocompletion": words(*known)}
