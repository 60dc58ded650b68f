"""The reader of JSON.

Python's own decoder, since others refuse NaN and Infinity, which ROS clients send, and round whole numbers of more than
64 bits. Numbers that a float cannot hold are refused: `float` and `math.isfinite` raise OverflowError for them.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

from uwsim.base.texts.text_file import decoded, read_limited

MOST_BYTES = 1 << 28
LONG = re.compile(r"[0-9]{300}|[0-9][eE][+]?0*[0-9]{3}")
"""Occurs in each number that may be beyond a float's range. Most texts have none and are decoded twice as fast."""


def json_value(text: str | bytes, name: str) -> Any:
    """Return the value in a JSON text, which may be NaN or infinite. name: of the text, for messages.

    Raises ValueError with the name, the line if there are several, and the rule.
    """
    if len(text) > MOST_BYTES:
        raise ValueError(f"{name}: {len(text)} bytes: must be at most {MOST_BYTES}")
    if not isinstance(text, str):
        text = decoded(text, name, "JSON text")
    try:
        if LONG.search(text) is None:
            return json.loads(text)
        return json.loads(text, parse_int=_whole, parse_float=_real)
    except json.JSONDecodeError as error:
        place = f"{name}:{error.lineno}" if "\n" in text else name
        raise ValueError(f"{place}: not JSON (column {error.colno}: {error.msg})") from None
    except _BeyondRangeError as error:
        before = text.count("\n", 0, text.find(error.digits)) + 1
        place = f"{name}:{before}" if "\n" in text else name
        raise ValueError(f"{place}: {error.digits:.30}...: must be a number in [-1.8e308, 1.8e308]") from None
    except RecursionError:
        raise ValueError(f"{name}: not JSON (nested too deeply)") from None


def json_object(text: str | bytes, name: str) -> dict[str, Any]:
    """Return the object in a JSON text; see json_value(). Raises ValueError."""
    found = json_value(text, name)
    if not isinstance(found, dict):
        raise ValueError(f"{name}: must be an object in JSON")
    return found


def read_json(path: Path, name: str = "") -> Any:
    """Return the value in a JSON file. name: the file's name, for messages. Raises ValueError."""
    name = name or str(path)
    return json_value(read_limited(path, name, MOST_BYTES), name)


class _BeyondRangeError(Exception):
    def __init__(self, digits: str) -> None:
        super().__init__(digits)
        self.digits = digits


def _whole(digits: str) -> int:
    _real(digits)
    return int(digits)


def _real(digits: str) -> float:
    value = float(digits)
    if math.isinf(value):
        raise _BeyondRangeError(digits)
    return value
