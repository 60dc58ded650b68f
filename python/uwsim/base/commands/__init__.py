"""The table of all commands for a simulator and its vehicles, neither of which this package imports.

Live simulators, logs, replays, links, services, remote vehicles and the station's page are all built from COMMANDS. A
new command is one entry in `table.py`; if callers need a method for it, add the method to `Commandable`.
"""

from uwsim.base.commands.command import SET_BOOL, TRIGGER, Argument, Command
from uwsim.base.commands.commandable import Commandable, Placeable, Steerable
from uwsim.base.commands.holds import HOLDS
from uwsim.base.commands.notes import CATEGORIES, COMMENT, NOTE, NOTES_MAX, TEXT_MAX, require_note
from uwsim.base.commands.table import ALL_STOP, COMMANDS, bound_command, command_named

__all__ = [
    "ALL_STOP",
    "CATEGORIES",
    "COMMANDS",
    "COMMENT",
    "HOLDS",
    "NOTE",
    "NOTES_MAX",
    "SET_BOOL",
    "TEXT_MAX",
    "TRIGGER",
    "Argument",
    "Command",
    "Commandable",
    "Placeable",
    "Steerable",
    "bound_command",
    "command_named",
    "require_note",
]
