"""The setting by which pydantic builds the validators of our models when they are first used, not at import."""

from __future__ import annotations

from pydantic import VERSION

DEFER_BUILD = tuple(int(part) for part in VERSION.split(".")[:2]) >= (2, 14)
"""Before pydantic 2.14, threads that use a model for the first time at once may validate with its base's rules
(pydantic pull request 13438)."""
