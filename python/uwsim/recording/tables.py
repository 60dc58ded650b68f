"""Converts a recording's channels to Arrow and pandas tables with one row per message, or to xarray datasets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.channels.ros.message_types import TIMES, Kind, fields

if TYPE_CHECKING:
    import pandas
    import pyarrow
    import xarray

    from uwsim.recording.messages import Messages

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
    import pyarrow

    kind = recording.info(topic).type
    columns = list(_columns(kind))
    rows: dict[str, list[Any]] = {name: [] for name, _, _ in columns}
    times_s = []
    for recorded in recording.messages(topic):
        message = recorded.message
        times_s.append(1e-9 * recorded.time_ns)
        for name, get, _ in columns:
            rows[name].append(get(message))
    arrays = {TIME: pyarrow.array(times_s, pyarrow.float64())}
    for name, _, part in columns:
        arrays[name] = pyarrow.array(rows[name], _arrow_type(part))
    return pyarrow.table(arrays)


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

    kind = recording.info(topic).type
    messages, times_s = [], []
    for recorded in recording.messages(topic):
        messages.append(recorded.message)
        times_s.append(1e-9 * recorded.time_ns)
    found = SPECIAL.get(kind, _plain_variables)(kind, messages)
    variables = {name: (dims, values) for name, (dims, values) in found.items()}
    made = xarray.Dataset(variables, coords={TIME: ("time", np.array(times_s))}, attrs={"topic": topic, "type": kind})
    if kind.endswith("/LaserScan") and messages:
        first = messages[0]
        angles = first.angle_min + first.angle_increment * np.arange(len(first.ranges))
        made = made.assign_coords(angle_rad=("beam", angles))
    return made


Column = tuple[str, Callable[[Any], Any], Kind]
Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]


def _columns(kind: str, path: str = "", get: Callable[[Any], Any] = lambda message: message) -> Iterator[Column]:
    """Yield each field's name, getter and kind. Nested messages are expanded, except in arrays."""
    for field in fields(kind, 2):
        if field.attribute is None:
            continue
        name, part = f"{path}{field.name}", _getter(get, field.attribute)
        if not field.kind.is_message or field.kind.length is not None:
            yield name, _plain_getter(part, field.kind), field.kind
        elif field.kind.base in TIMES:
            yield f"{name}_ns", _nanoseconds(part), Kind("int64", None, 0)
        else:
            yield from _columns(field.kind.base, f"{name}.", part)


def _getter(get: Callable[[Any], Any], attribute: str) -> Callable[[Any], Any]:
    return lambda message: getattr(get(message), attribute)


def _nanoseconds(get: Callable[[Any], Any]) -> Callable[[Any], int]:
    def nanoseconds(message: Any) -> int:
        time = get(message)
        return int(time.sec * 1_000_000_000 + time.nanosec)

    return nanoseconds


def _plain_getter(get: Callable[[Any], Any], kind: Kind) -> Callable[[Any], Any]:
    if not kind.is_message:
        return get
    return lambda message: [_plain(value, kind.base) for value in get(message)]


def _plain(message: Any, kind: str) -> dict[str, Any]:
    """Convert a message in an array to a dict of its fields."""
    found = {}
    for field in fields(kind, 2):
        if field.attribute is not None:
            value = getattr(message, field.attribute)
            if field.kind.is_message:
                one = field.kind.length is None
                value = _plain(value, field.kind.base) if one else [_plain(v, field.kind.base) for v in value]
            found[field.name] = value
    return found


def _arrow_type(kind: Kind) -> Any:
    import pyarrow

    if kind.length is not None:
        return pyarrow.list_(_arrow_type(Kind(kind.base, None, 0)))
    if kind.is_message:
        parts = [(f.name, _arrow_type(f.kind)) for f in fields(kind.base, 2) if f.attribute is not None]
        return pyarrow.struct(parts)
    names = {"string": "string", "wstring": "string", "bool": "bool_", "char": "uint8", "byte": "uint8"}
    return getattr(pyarrow, names.get(kind.base, kind.base))()


def _plain_variables(kind: str, messages: list[Any]) -> Variables:
    found: Variables = {}
    for name, get, part in _columns(kind):
        if part.is_message or part.base in ("string", "wstring"):
            continue
        values = [get(message) for message in messages]
        if part.length is None:
            found[name] = (("time",), np.array(values))
        else:
            found[name] = (("time", name), _padded(values))
    return found


def _scan_variables(kind: str, messages: list[Any]) -> Variables:
    found = _plain_variables(kind, messages)
    for name in ("ranges", "intensities"):
        _, values = found.pop(name)
        if values.shape[1]:
            found[name] = (("time", "beam"), values)
    return found


def _cloud_variables(kind: str, messages: list[Any]) -> Variables:
    found: Variables = {}
    names = [field.name for field in messages[0].fields] if messages else []
    for name in names:
        found[name] = (("time", "point"), _padded([cloud_field(message, name) for message in messages]))
    return found


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


def _picture_variables(kind: str, messages: list[Any]) -> Variables:
    import io

    from PIL import Image

    pictures = [np.asarray(Image.open(io.BytesIO(bytes(message.data))).convert("RGB")) for message in messages]
    return {"rgb": (("time", "row", "column", "channel"), np.array(pictures))}


def _image_variables(kind: str, messages: list[Any]) -> Variables:
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


SPECIAL: dict[str, Callable[[str, list[Any]], Variables]] = {
    "sensor_msgs/msg/LaserScan": _scan_variables,
    "sensor_msgs/msg/PointCloud2": _cloud_variables,
    "sensor_msgs/msg/CompressedImage": _picture_variables,
    "sensor_msgs/msg/Image": _image_variables,
}
