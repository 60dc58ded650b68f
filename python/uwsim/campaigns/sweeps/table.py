"""The table of a sweep: a Parquet file with one row per run."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.extras import need_extra
from uwsim.campaigns.sweeps.rows import Rows

TABLE = "runs.parquet"


def write_table(path: Path, rows: Rows, notes: Mapping[str, str]) -> None:
    """Write the rows atomically. notes: metadata for the file. Raises OSError or MissingExtraError.

    The same rows give the same bytes with the same version of pyarrow. Columns of mixed types become text.
    """
    need_extra("pyarrow", "the table of a sweep")
    import pyarrow as pa
    from pyarrow import parquet

    columns = {name: pa.array(_of_one_kind([row.get(name) for row in rows.rows])) for name in rows.columns}
    # an empty column, such as `error` if no run failed
    columns = {n: c.cast(pa.string()) if c.type == pa.null() else c for n, c in columns.items()}
    table = pa.table(columns).replace_schema_metadata(dict(notes))
    content = io.BytesIO()
    parquet.write_table(table, content, compression="zstd")
    write_atomically(path, content.getvalue())


def _of_one_kind(values: list[Any]) -> list[Any]:
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    if kinds == {int} and max(abs(value) for value in values if value is not None) >= 2**63:
        kinds.add(str)
    return values if len(kinds) < 2 else [None if value is None else str(value) for value in values]
