"""The files of EuRoC's layout (Burri et al. 2016): one folder per instrument, with data.csv and sensor.yaml.

Time stamps are in nanoseconds of simulated time. File names have 19 digits, so alphabetical order is chronological.
T_BS is the pose of the sensor's frame in the body frame: x forward, y left, z up.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from ruamel.yaml import YAML


class Rows:
    """A data.csv that grows row by row."""

    def __init__(self, folder: Path, columns: Sequence[str]) -> None:
        """Create the folder and the file. Raises OSError."""
        folder.mkdir(parents=True)
        self._file = (folder / "data.csv").open("w", newline="\n")
        self._file.write(",".join(["#timestamp [ns]", *columns]) + "\n")
        self.count = 0

    def add(self, stamp_ns: int, *values: float | str) -> None:
        """Append a row; numbers are written so that they read back unchanged. Raises OSError."""
        texts = [value if isinstance(value, str) else repr(float(value)) for value in values]
        self._file.write(",".join([str(stamp_ns), *texts]) + "\n")
        self.count += 1

    def close(self) -> None:
        """Close the file. Raises OSError."""
        self._file.close()


class Files:
    """A folder with one file per time stamp, as for EuRoC's cameras, and the data.csv that lists them."""

    def __init__(self, folder: Path, suffix: str) -> None:
        """Create the folders. Raises OSError."""
        self._rows = Rows(folder, ["filename"])
        self._data, self._suffix = folder / "data", suffix
        self._data.mkdir()
        self.last_ns = -1

    @property
    def count(self) -> int:
        """The number of files."""
        return self._rows.count

    def add(self, stamp_ns: int, content: bytes) -> None:
        """Write a file. Raises OSError."""
        name = f"{stamp_ns:019d}{self._suffix}"
        (self._data / name).write_bytes(content)
        self._rows.add(stamp_ns, name)
        self.last_ns = stamp_ns

    def close(self) -> None:
        """Close the table. Raises OSError."""
        self._rows.close()


def write_sensor(folder: Path, kind: str, comment: str, body_from_sensor: ArrayLike, more: Mapping[str, Any]) -> None:
    """Write a sensor.yaml. body_from_sensor: (4, 4). more: the keys specific to the kind of sensor. Raises OSError."""
    data = np.asarray(body_from_sensor, float).ravel().tolist()
    pose = {"cols": 4, "rows": 4, "data": data}
    write_yaml(folder / "sensor.yaml", {"sensor_type": kind, "comment": comment, "T_BS": pose, **more})


def write_yaml(path: Path, values: Mapping[str, Any]) -> None:
    """Write a YAML file that YAML 1.1 readers, such as Kalibr's, can also read. Raises OSError."""
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None  # lists of numbers on one line
    yaml.width = 4096
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.representer.add_representer(float, _represented)
    text = io.StringIO()
    yaml.dump(dict(values), text)
    path.write_text(text.getvalue())


def _represented(representer: Any, value: float) -> Any:
    """Return a float in YAML 1.1 notation: 1.0e-05, since 1e-05 would be read as text."""
    text = repr(value)
    text = text.replace("e", ".0e") if "e" in text and "." not in text else text
    special = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}
    return representer.represent_scalar("tag:yaml.org,2002:float", special.get(text, text))
