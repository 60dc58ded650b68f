"""Text from outside is read by one reader for each kind, which refuses with file, line, value and rule."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from uwsim.base.arguments import is_number
from uwsim.base.texts.csv_table import read_csv
from uwsim.base.texts.json_text import json_object, json_value, read_json
from uwsim.base.texts.yaml_document import read_yaml
from uwsim.channels.request import field
from uwsim.live.pace import checked_speed
from uwsim.operator.station.controls.plan import Plan

ROOT = Path(__file__).parents[3]
HUGE = 10**400
READERS = """json.loads json.load orjson.loads csv.DictReader csv.reader numpy.loadtxt numpy.genfromtxt pandas.read_csv
    yaml.safe_load ruamel.yaml.YAML xml.etree.ElementTree.parse"""
OTHERS = [f"import {name.rpartition('.')[0]}\n\n{name}('a')\n" for name in READERS.split()]


def test_the_lint_refuses_other_readers(tmp_path: Path) -> None:
    for number, program in enumerate(OTHERS):
        (tmp_path / f"other{number}.py").write_text(program)
    words = [sys.executable, "-m", "ruff", "check", "--select=TID251", "--output-format=concise"]
    settings = ["--config", str(ROOT / "pyproject.toml"), "--no-cache"]
    found = subprocess.run([*words, *settings, tmp_path], capture_output=True, text=True, cwd=ROOT, check=False)
    refused = {line.split(":")[0] for line in found.stdout.splitlines() if "text from outside is read by uwsim" in line}
    assert len(refused) == len(OTHERS), found.stdout


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("{", r"a\.json: not JSON \(column"),
        ('{"a": 1,\n "b": }', r"a\.json:2: not JSON \(column 7"),
        (f'{{"a": 1,\n "b": {HUGE}}}', r"a\.json:2: 1000.*must be a number in"),
        ("[1e400]", r"a\.json: 1e400.*must be a number in"),
        ("[" * 100_000, r"a\.json: not JSON \(nested too deeply"),
        ("9" * 5000, r"a\.json: 999.*must be a number in"),
        ("\udcff", "not JSON"),
        (b"\n\xff", r"a\.json:2: not UTF-8"),
    ],
)
def test_json_is_refused_at_its_line(text: str | bytes, rule: str) -> None:
    with pytest.raises(ValueError, match=rule) as refused:
        json_value(text, "a.json")
    assert len(str(refused.value)) < 200


def test_json_keeps_long_whole_numbers_and_the_values_that_ros_sends(tmp_path: Path) -> None:
    assert json_value(f"[{2**70}, 1.5, NaN, -Infinity, 1e300, {10**308}]", "a")[0] == 2**70
    assert json_value(b'\xef\xbb\xbf{"a": null}', "a") == {"a": None}
    with pytest.raises(ValueError, match="a: must be an object"):
        json_object("[1]", "a")
    with pytest.raises(ValueError, match="cannot be read"):
        read_json(tmp_path / "absent.json")


def test_numbers_that_a_float_cannot_hold_are_refused_by_each_check() -> None:
    assert is_number(2**70) and is_number(-1.5) and not is_number(True)
    assert not any(map(is_number, (HUGE, -HUGE, float("nan"), float("inf"), "1", None)))
    for speed in (HUGE, -HUGE, float("nan"), True):
        with pytest.raises(ValueError, match="speed = "):
            checked_speed(speed)
    for request in ({"points_m": [[0, 0, HUGE]]}, {"points_m": [[0, 0, 0]], "speed_m_s": HUGE}):
        with pytest.raises(ValueError, match=r"points_m\[0\]|speed_m_s"):
            Plan.of(request, (0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="a = 1000"):
        field({"a": HUGE}, "a", float, 0.0)


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (b"t,x\n0,1\n\n# pause\n1,inf\n", r"a\.csv:5: x = 'inf': must be a finite number"),
        (b"t,x\n0,1_0\n", r"a\.csv:2: x = '1_0': must be a finite number"),
        (b"t,x\n0\n", r"a\.csv:2: 1 values: must be 2"),
        (b"t,t\n0,1\n", r"a\.csv:1: column 't' is named twice"),
        (b"t,y\n0,1\n", r"no column 'x'; there are: t, y"),
        (b't,x\n0,"1\n', r"a\.csv:2: not CSV"),
        (b"t,x\n", "has no rows"),
        (b"", "has no rows"),
        (b"t,x\n\xff,1\n", r"a\.csv:2: not UTF-8"),
        (b"t,x\n\0,1\n", "a binary file"),
        (b"t,x\n0," + b"1" * 200_000 + b"\n", "not CSV"),
    ],
)
def test_a_table_is_refused_at_its_line(content: bytes, rule: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(ValueError, match=rule) as refused:
        read_csv(tmp_path / "a.csv").numbers("x")
    assert "a.csv" in str(refused.value) and "\n" not in str(refused.value)


def test_a_table_returns_its_columns_and_warns_if_cut_short(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b'\xef\xbb\xbf# log\n t ,"x"\r\n0,1\r\n1,\r\n2,nan\r\n3,4')
    with pytest.warns(UserWarning, match="may be cut short"):
        table = read_csv(tmp_path / "a.csv")
    np.testing.assert_array_equal(table.numbers("t"), [0, 1, 2, 3])
    np.testing.assert_array_equal(table.numbers("x", may_lack=True), [1, np.nan, np.nan, 4])


def test_sizes_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("uwsim.base.texts.csv_table.MOST_CELLS", 3)
    (tmp_path / "a.csv").write_bytes(b"t,x\n0,1\n1,2\n")
    with pytest.raises(ValueError, match="at most 3 values"):
        read_csv(tmp_path / "a.csv")
    (tmp_path / "a.yaml").write_bytes(bytes(300_001))
    for path, rule in ((tmp_path / "a.yaml", "must be at most 300000"), (Path("/dev/zero"), "is no regular file")):
        with pytest.raises(ValueError, match=rule):
            read_yaml(path)
    monkeypatch.setattr("uwsim.base.texts.json_text.MOST_BYTES", 3)
    with pytest.raises(ValueError, match="must be at most 3"):
        json_value("[1, 2]", "a")
