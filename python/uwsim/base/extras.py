"""Optional dependencies, which a plain `pip install uwsim` omits, and the extras that install them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType

EXTRA_OF = {
    "matplotlib": "figures",
    "jinja2": "figures",
    "PIL": "cameras",
    "simplejpeg": "cameras",
    "shapely": "files",
    "assimp_py": "files",
    "networkx": "files",
    "rasterio": "files",
    "laspy": "files",
    "lazrs": "files",
    "rosbags": "ros",
    "websockets": "ros",
    "cbor2": "ros",
    "brping": "ros",
    "mcap": "recording",
    "GSFU": "survey",
    "pyxtf": "survey",
    "pygeomag": "survey",
    "coacd": "robots",
    "cryptography": "sweeps",
    "cascadio": "step",
    "cyclonedds": "ros2",
    "zenoh": "zenoh",
    "foxglove": "foxglove",
    "pymavlink": "mavlink",
    "xacro": "robots",
    "xxhash": "robots",
    "pandas": "tables",
    "pyarrow": "tables",
    "xarray": "tables",
    "gymnasium": "learning",
    "cma": "learning",
    "stable_baselines3": "rl",
    "distributed": "sweeps",
    "h5py": "files",
}
"""The smallest extra in pyproject.toml that installs each module."""


class MissingExtraError(ImportError, ValueError):
    """Raised if a package for an optional feature is missing. Also a ValueError, since the user can fix it."""


def need_extra(module: str, what: str) -> None:
    """Raise MissingExtraError, with the command that installs the module, if the module cannot be found."""
    if find_spec(module) is None:
        message = f"{what} needs '{module}', which is not installed: pip install 'uwsim[{EXTRA_OF[module]}]'"
        raise MissingExtraError(message, name=module)


def explained(error: ImportError) -> str:
    """Return the error's text or, if another package failed to import an optional package, the command to run."""
    if isinstance(error, MissingExtraError) or error.name not in EXTRA_OF:
        return str(error)
    return f"'{error.name}' is needed and not installed: pip install 'uwsim[{EXTRA_OF[error.name]}]'"


class _MissingExtras:
    """An import finder, placed last, that explains failed imports in uwsim and ignores those in other packages."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname in EXTRA_OF and (importer := _importing_module()).startswith("uwsim."):
            need_extra(fullname, importer)
        return None


def _importing_module() -> str:
    """Return the name of the module that is executing an import, or "" for a look-up such as find_spec."""
    frame, imports = sys._getframe(2), False
    while frame.f_globals.get("__name__", "").partition(".")[0] in ("importlib", "_frozen_importlib"):
        imports |= frame.f_code.co_name == "_find_and_load"
        if frame.f_back is None:
            return ""
        frame = frame.f_back
    return str(frame.f_globals.get("__name__", "")) if imports else ""


def explain_missing_extras() -> None:
    """Add the install command to the errors raised when uwsim fails to import an optional package."""
    if not any(isinstance(finder, _MissingExtras) for finder in sys.meta_path):
        sys.meta_path.append(_MissingExtras())
