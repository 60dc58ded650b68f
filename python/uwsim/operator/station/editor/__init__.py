"""The scene editor: one scenario's YAML text, edited part by part, checked, saved, and put into a paused simulator."""

from uwsim.operator.station.editor.editor import Editor

__all__ = ["Editor"]
