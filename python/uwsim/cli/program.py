"""The `uwsim` command: its subcommands, the handling of errors, and `--cite`.

Each subcommand has a separate file and imports its dependencies when it runs, so that --help is fast.
"""

from __future__ import annotations

import atexit
import gc
import mmap
import os
import re
import resource
import signal
import subprocess
import sys
import warnings
from pathlib import Path
from traceback import walk_tb
from typing import Annotated, Any, NoReturn

import typer

from uwsim.base.stoppable import outliving_terminal
from uwsim.cli.exit_codes import FAILED, exit_code_help, exit_interrupted
from uwsim.cli.groups import Program
from uwsim.cli.options import SETTINGS
from uwsim.cli.values import UsageError, refusal

CITATION = "CITATION.cff"


def bibtex() -> str:
    """Return the entry. Raises OSError or ValueError if CITATION.cff is missing or damaged."""
    from uwsim.base.texts.yaml_document import read_yaml
    from uwsim.scenario.fingerprint import build_fingerprint
    from uwsim.scenario.read.assets import assets_folder

    packaged = assets_folder() / CITATION
    path = packaged if packaged.exists() else assets_folder().parent / CITATION  # the latter in a clone
    cited = read_yaml(path).values
    commit = cited.get("commit") or _commit_of(path.parent)  # written where a wheel is built
    values = {
        "title": cited["title"],
        "author": " and ".join(f"{{{author['name']}}}" for author in cited["authors"]),  # no first and last names
        "year": str(cited["date-released"])[:4],
        "version": cited["version"],
        "url": cited.get("repository-code"),
        "note": ", ".join([*([f"commit {commit}"] if commit else []), f"build {build_fingerprint()}"]),
    }
    lines = [f"  {key} = {{{value}}},\n" for key, value in values.items() if value]
    return f"@software{{uwsim-{cited['version']},\n{''.join(lines)}}}"


def _commit_of(folder: Path) -> str:
    """Return the commit of a clone, with -dirty if its files differ from it; empty without Git."""
    if not (folder / ".git").exists():
        return ""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


COLLECT_EVERY = 200_000
"""Objects between garbage collections, instead of 700: imports and scenarios create many, nearly all of which stay."""

LINEAR_ALGEBRA_BYTES = 250_000_000
"""Address space that NumPy, SciPy and their OpenBLAS take, with one thread."""

app = typer.Typer(
    name="uwsim",
    cls=Program,
    help="A fast, headless underwater robotics simulator: fly an ROV, sweep a multibeam, get an OctoMap.",
    epilog=exit_code_help(),
    **{**SETTINGS, "add_completion": True},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"uwsim {version('uwsim')}")
        raise typer.Exit


def _print_citation(wanted: bool) -> None:
    if wanted:
        from uwsim.cli.program import bibtex

        typer.echo(bibtex())
        raise typer.Exit


@app.callback()
def _program(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    cite: Annotated[
        bool, typer.Option("--cite", callback=_print_citation, is_eager=True, help="Show a BibTeX entry and exit.")
    ] = False,
) -> None:
    """A fast, headless underwater robotics simulator: fly an ROV, sweep a multibeam, get an OctoMap."""


def run_program() -> NoReturn:
    """Run the command. A user's mistake produces one line on stderr and a non-zero exit code, without a traceback."""
    is_scarce = resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY
    if is_scarce:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # it claims 33 MB of address space for each
    gc.set_threshold(COLLECT_EVERY)
    atexit.register(gc.freeze)  # otherwise the interpreter would search all objects for garbage before it ends
    sys.stdout, sys.stderr = (outliving_terminal(each) if each.isatty() else each for each in (sys.stdout, sys.stderr))
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]  # for ASCII terminals
    warnings.showwarning = _show_warning
    if "_UWSIM_COMPLETE" in os.environ:  # a shell asks for completions
        from uwsim.cli.values import offer_fast

        offer_fast()
        warnings.simplefilter("ignore")  # they would appear in the line that is being typed
    try:
        _require_no_empty_word(sys.argv[1:])
        if is_scarce:
            _load_linear_algebra()
        code = app(args=sys.argv[1:] or ["--help"], prog_name="uwsim", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):  # before a command runs, or at a prompt
        exit_interrupted(signal.SIGINT, None)
    except (ValueError, OSError, MemoryError, ImportError) as error:  # ImportError: no memory for a library
        if os.environ.get("UWSIM_TRACEBACK"):
            raise
        if is_scarce and _ended_an_import(error):
            _print_error(_too_little_room(error))
            sys.exit(FAILED)
        for mistake in getattr(error, "mistakes", None) or [_message_of(error)]:  # mistakes in a scenario file
            _print_error(mistake + _notes_of(error))
        sys.exit(getattr(error, "exit_code", FAILED))
    except Exception as error:
        if is_scarce and _ended_an_import(error) and not os.environ.get("UWSIM_TRACEBACK"):
            _print_error(_too_little_room(error))
            sys.exit(FAILED)
        if str(error) == "can't start new thread":  # CPython's RuntimeError
            _print_error("the system allows no further thread: its limit of processes, threads or memory is reached")
            sys.exit(FAILED)
        if str(error).startswith("Symlink loop from "):  # pathlib's RuntimeError, an OSError from Python 3.13 on
            _print_error(f"{str(error)[18:]}: is a link to itself")
            sys.exit(FAILED)
        # Recognise typer's usage errors by their method, since the class's module depends on typer's version.
        if not hasattr(error, "format_message"):
            raise
        _print_error(refusal(error) + _notes_of(error))
        sys.exit(getattr(error, "exit_code", FAILED))
    sys.exit(code if isinstance(code, int) else 0)


def _ended_an_import(error: Exception) -> bool:
    """Return whether a library that is installed could not be imported, or what it lacks ended another's import."""
    if isinstance(error, ModuleNotFoundError) or not isinstance(error, ImportError | AttributeError):
        return False
    return any(frame.f_code.co_name == "<module>" for frame, _ in walk_tb(error.__traceback__))


def _too_little_room(error: Exception) -> str:
    """Return the message for an error of an import where the address space is limited.

    A module whose first import found no room is left half made, and lacks names at the next.
    """
    shown = " ".join(str(error).split())[:200]
    return f"out of memory: a library could not be loaded within the limit of address space ({shown})"


def _notes_of(error: Exception) -> str:
    """Return what groups.WithDefault adds to an error."""
    return "".join(getattr(error, "__notes__", ()))


def _message_of(error: Exception) -> str:
    if isinstance(error, MemoryError):
        return f"out of memory: {error}" if str(error) not in ("", "std::bad_alloc") else "out of memory"
    if isinstance(error, ImportError):
        from uwsim.base.extras import explained

        return explained(error) or type(error).__name__
    return str(error) or type(error).__name__


def _require_no_empty_word(words: list[str]) -> None:
    """Raise UsageError for an empty argument, as from an unset shell variable, which would select a default."""
    for before, word in zip(["", *words], words, strict=False):
        option = re.fullmatch(r"(--[\w-]+)=", word)
        if not word or option:
            name = option[1] if option else before if before.startswith("--") else "an argument"
            raise UsageError(f"{name} is empty: give it a value, or leave it out")


def _load_linear_algebra() -> None:
    """Load NumPy's and SciPy's OpenBLAS, and their buffers, while there is room. Raises MemoryError if there is none.

    OpenBLAS asks for a buffer forever if it gets none, deaf to SIGTERM. Where the address space is limited, it must
    therefore not be loaded, or first used, once a flight has taken the room.
    """
    try:
        mmap.mmap(-1, LINEAR_ALGEBRA_BYTES).close()
    except OSError:
        raise MemoryError("the libraries of linear algebra do not fit into the limit of address space") from None
    import numpy as np
    from scipy.linalg.blas import dgemm

    square = np.ones((200, 200))  # larger than what is multiplied without a buffer
    dgemm(1.0, square @ square, square)


def _print_error(message: str) -> None:
    """Print a message on one line, even if a library wrote several."""
    typer.echo(f"uwsim: error: {_printable(' '.join(message.split()))}", err=True)


def _printable(text: str) -> str:
    """Escape control characters for the terminal, since names in an untrusted file may contain any."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def _show_warning(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    """Print warnings about a user's scenario; discard libraries' warnings, which are for programmers."""
    if issubclass(category, UserWarning):
        typer.echo(f"uwsim: warning: {_printable(' '.join(str(message).split()))}", err=True)
