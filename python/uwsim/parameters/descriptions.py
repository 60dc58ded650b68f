"""The descriptions of a model's fields: its docstring says `key, other_key [unit]: words.` of each."""

from __future__ import annotations

import functools
import inspect
import re

from uwsim.scenario.spec.fields import Model

KEY = r"[a-z][a-z0-9_]*(?: \[[^\]]*\])?"
KEYS = re.compile(rf"(?:^|(?<=[.;:] )|(?<=\n))({KEY}(?:,\s{KEY})*):\s")


@functools.cache
def descriptions(model: type[Model]) -> dict[str, str]:
    """Return what the docstring says of each field, by name; nothing for those that it does not mention."""
    text = inspect.getdoc(model) or ""
    found: dict[str, str] = {}
    starts = [match for match in KEYS.finditer(text) if _fields(match[1]) & set(model.model_fields)]
    for k, match in enumerate(starts):
        end = starts[k + 1].start() if k + 1 < len(starts) else len(text)
        words = " ".join(text[match.end() : end].split())
        found |= dict.fromkeys(_fields(match[1]), words)
    matrices = {key + "_matrix": words for key, words in found.items() if key + "_matrix" in model.model_fields}
    return matrices | found


def _fields(keys: str) -> set[str]:
    return {key.partition(" ")[0] for key in re.split(r",\s", keys)}
