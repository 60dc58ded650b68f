"""Converts a recording's channels to Arrow and pandas tables with one row per message, or to xarray datasets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.channels.ros.message_types import TIMES, Kind, fields

if TYPE_CHECKING:
    import pandas
    import pyarrow
    import xarray

    from uwsim.recording.messages import Messages, Recorded

TIME = "time_s"
BLOCK = {1: np.int8, 2: np.uint8, 3: np.int16, 4: np.uint16, 5: np.int32, 6: np.uint32, 7: np.float32, 8: np.float64}
"""The NumPy types of sensor_msgs/PointField's data types."""


def arrow(recording: Messages, topic: str) -> pyarrow.Table:
    """Return a channel as an Arrow table.

    The columns are TIME, the simulated time in seconds at which the message was recorded, and each field with its path
    as name, such as "pose.pose.position.x". Time stamps are integers in nanoseconds. Arrays become lists, and messages
    in arrays become structs.
    """
    need_extra("pyarrow", "a recording as a table")
    return _table(recording.info(topic).type, list(recording.messages(topic)))


def pandas_frame(recording: Messages, topic: str) -> pandas.DataFrame:
    """Return a channel as a pandas DataFrame indexed by simulated seconds, with the columns of `arrow`."""
    need_extra("pandas", "a recording as a table")
    return arrow(recording, topic).to_pandas().set_index(TIME)


def dataset(recording: Messages, topic: str) -> xarray.Dataset:
    """Return a channel as an xarray Dataset over the coordinate TIME.

    Numbers have dimension (time,); arrays have (time, FIELD) and are padded with NaN if their length varies. A
    LaserScan has (time, beam) and the coordinate `angle_rad`; a PointCloud2 has its fields as (time, point); pictures
    are (time, row, column[, rgb]). Text and messages in arrays are omitted.
    """
    need_extra("xarray", "a recording as a dataset")
    import xarray

    kind, found = recording.info(topic).type, list(recording.messages(topic))
    messages = [recorded.message for recorded in found]
    variables = SPECIAL[kind](messages) if kind in SPECIAL else _plain_variables(_table(kind, found))
    coordinates: dict[str, Any] = {TIME: ("time", np.array([1e-9 * recorded.time_ns for recorded in found]))}
    if kind.endswith("/LaserScan") and messages:
        for name in ("ranges", "intensities"):
            _, values = variables.pop(name)
            if values.shape[1]:
                variables[name] = ("time", "beam"), values
        first = messages[0]
        coordinates["angle_rad"] = "beam", first.angle_min + first.angle_increment * np.arange(len(first.ranges))
    return xarray.Dataset(variables, coords=coordinates, attrs={"topic": topic, "type": kind})


Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]


def _table(kind: str, found: Sequence[Recorded]) -> pyarrow.Table:
    import pyarrow

    times_s = pyarrow.array([1e-9 * recorded.time_ns for recorded in found], pyarrow.float64())
    rows = pyarrow.array([_plain(recorded.message, kind) for recorded in found], _struct(kind))
    table = pyarrow.table({TIME: times_s, "": rows})
    while any(pyarrow.types.is_struct(each.type) for each in table.schema):
        table = table.flatten()
    return table.rename_columns([name.removeprefix(".") for name in table.column_names])


def _parts(kind: str) -> Iterator[tuple[str, str, Kind, bool]]:
    """Yield name, attribute and kind of each field of a type, and whether it is a time stamp."""
    for field in fields(kind, 2):
        if field.attribute is not None:
            is_time = field.kind.base in TIMES and field.kind.length is None
            yield f"{field.name}_ns" if is_time else field.name, field.attribute, field.kind, is_time


def _plain(message: Any, kind: str) -> dict[str, Any]:
    """Convert a message to a dict of its fields."""
    found = {}
    for name, attribute, part, is_time in _parts(kind):
        value = getattr(message, attribute)
        if is_time:
            value = value.sec * 1_000_000_000 + value.nanosec
        elif part.is_message:
            one = part.length is None
            value = _plain(value, part.base) if one else [_plain(each, part.base) for each in value]
        found[name] = value
    return found


def _struct(kind: str) -> pyarrow.DataType:
    import pyarrow

    return pyarrow.struct(
        [(name, pyarrow.int64() if is_time else _arrow_type(part)) for name, _, part, is_time in _parts(kind)]
    )


def _arrow_type(kind: Kind) -> Any:
    import pyarrow

    if kind.length is not None:
        return pyarrow.list_(_arrow_type(Kind(kind.base, None, 0)))
    if kind.is_message:
        return _struct(kind.base)
    names = {"string": "string", "wstring": "string", "bool": "bool_", "char": "uint8", "byte": "uint8"}
    return getattr(pyarrow, names.get(kind.base, kind.base))()


def _plain_variables(table: pyarrow.Table) -> Variables:
    """Return the columns of numbers, and those of lists of numbers as rows."""
    from pyarrow import types

    found: Variables = {}
    for name in table.column_names[1:]:
        column = table[name].combine_chunks()
        if types.is_list(column.type) and types.is_primitive(column.type.value_type):
            values = column.values.to_numpy(zero_copy_only=False)
            found[name] = ("time", name), _padded([values[a:b] for a, b in pairwise(column.offsets.to_numpy())])
        elif types.is_primitive(column.type):
            found[name] = ("time",), np.array(column.to_pylist())
    return found


def _cloud_variables(messages: list[Any]) -> Variables:
    names = [field.name for field in messages[0].fields] if messages else []
    return {name: (("time", "point"), _padded([cloud_field(each, name) for each in messages])) for name in names}


def cloud_field(message: Any, name: str) -> NDArray[Any]:
    """Return one field of a PointCloud2, (points,). Raises ValueError if there is no such field."""
    for field in message.fields:
        if field.name == name:
            element = np.dtype(BLOCK[field.datatype]).newbyteorder(">" if message.is_bigendian else "<")
            layout = np.dtype(
                {"names": ["value"], "formats": [element], "offsets": [field.offset], "itemsize": message.point_step}
            )
            return np.frombuffer(message.data, layout, message.width * message.height)["value"]
    raise ValueError(f"field = {name!r}: must be one of {', '.join(field.name for field in message.fields)}")


def _picture_variables(messages: list[Any]) -> Variables:
    import io

    from PIL import Image

    pictures = [np.asarray(Image.open(io.BytesIO(bytes(message.data))).convert("RGB")) for message in messages]
    return {"rgb": (("time", "row", "column", "channel"), np.array(pictures))}


def _image_variables(messages: list[Any]) -> Variables:
    layouts = {"32FC1": np.float32, "mono8": np.uint8, "mono16": np.uint16, "16UC1": np.uint16}
    images = []
    for message in messages:
        if message.encoding not in layouts:
            raise ValueError(f"encoding = {message.encoding}: must be one of {', '.join(layouts)}")
        images.append(np.frombuffer(message.data, layouts[message.encoding]).reshape(message.height, message.width))
    return {"image": (("time", "row", "column"), np.array(images))}


def _padded(arrays: list[Any]) -> NDArray[Any]:
    """Return arrays as the rows of one array, with shorter ones padded with NaN."""
    lengths = {len(array) for array in arrays}
    if len(lengths) <= 1:
        return np.array(arrays).reshape(len(arrays), -1) if lengths != {0} else np.zeros((len(arrays), 0))
    rows = np.full(
        (len(arrays), max(lengths)), np.nan, np.result_type(np.float32, *{np.asarray(a).dtype for a in arrays})
    )
    for row, array in zip(rows, arrays, strict=True):
        row[: len(array)] = array
    return rows


SPECIAL: dict[str, Callable[[list[Any]], Variables]] = {
    "sensor_msgs/msg/PointCloud2": _cloud_variables,
    "sensor_msgs/msg/CompressedImage": _picture_variables,
    "sensor_msgs/msg/Image": _image_variables,
}
