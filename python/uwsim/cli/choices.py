"""Options and arguments that accept one of a fixed set of words, which is checked early and completed by the shell."""

from __future__ import annotations

from typing import Any

import typer

from uwsim.cli.bounds import UsageError, option_name
from uwsim.cli.values import words


def one_of(*known: str) -> dict[str, Any]:
    """Return typer's settings for a parameter that accepts one or several of these words."""

    def check(param: typer.CallbackParam, value: Any) -> Any:
        for word in value if isinstance(value, list) else (value,):
            if word is not None and word not in known:
                from uwsim.base.did_you_mean import did_you_mean

                rule = f"must be one of {', '.join(known)}{did_you_mean(word, known)}"
                raise UsageError(f"{option_name(param)} = '{word[:40]}': {rule}")
        return value

    return {"callback": check, "autocompletion": words(*known)}
