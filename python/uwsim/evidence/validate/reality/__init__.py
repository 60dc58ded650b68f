"""The reality suite: comparisons with data measured by others, in files that are not part of the package.

docs/inside/reality.md lists where each file comes from, and which differences remain unexplained. A data set is a
module with FILE, relative to the data folder, and `checks(data) -> list[Check]`, and an entry in DATA_SETS. The group
of each check begins with its kind (kinds.py): whether the simulator predicts the measured value or was given it.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from pathlib import Path

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.reality.kinds import PREDICTED

DATA_SETS = ("thrust", "instruments", "bathymetry", "soundings", "arm_tilts", "arm_motion", "glides")
SOURCES = "docs/inside/reality.md lists the sources"


def run(data: Path | None) -> list[Check]:
    """Return the checks of all data sets in the folder `data`, predictions first.

    A data set whose file or reader is missing is skipped with a warning. Raises ValueError if there is no folder or
    none of the files.
    """
    if data is None:
        raise ValueError(f"validate reality: needs --data FOLDER; {SOURCES} of its files")
    found: list[Check] = []
    for name in DATA_SETS:
        try:
            module = import_module(f"{__name__}.{name}")
        except ModuleNotFoundError as error:
            warnings.warn(f"validate reality: {name} is left out: {error}", stacklevel=2)
            continue
        if (data / module.FILE).is_file():
            found += module.checks(data)
        else:
            warnings.warn(f"validate reality: {name} is left out: no {data / module.FILE}; {SOURCES}", stacklevel=2)
    if not found:
        raise ValueError(f"validate reality: no data in {data}; {SOURCES}")
    return sorted(found, key=lambda check: not check.group.startswith(PREDICTED))
