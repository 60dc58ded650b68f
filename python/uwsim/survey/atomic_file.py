"""What moved to uwsim.atomic_file, under its old name."""

from uwsim.atomic_file import write_atomically

__all__ = ["write_atomically"]
