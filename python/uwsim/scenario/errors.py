"""The one error that scenario, terrain and mesh files raise."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario or a file it names cannot be used; the message is one line that says where and what to do."""
