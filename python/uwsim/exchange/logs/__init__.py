"""Logs of vehicles, as commands and motion."""
