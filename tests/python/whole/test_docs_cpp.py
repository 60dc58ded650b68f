"""C++ in the documentation: its sources and tests compile, and its tables are ours plus one entry."""

import importlib
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from docs_pages import PAGES, ROOT, blocks, page_named

INCLUDES = ["-I", str(ROOT / "cpp"), "-I", str(ROOT / "tests/cpp"), "-isystem", "/usr/include/eigen3"]
TABLES = {
    "add-a-sensor": ("cpp/uwsim/sensors/sensor_kinds.cpp", "kSalinity"),
    "add-a-sonar": ("cpp/uwsim/sonar/imaging/imaging_kinds.cpp", "kEchoSounder"),
}


def kind_of(block: str) -> str:
    return "test" if "TEST" in block else "table" if "kKinds" in block else "source"


def one(name: str, kind: str) -> str:
    (found,) = (block for block in blocks(page_named(name), "cpp") if kind_of(block) == kind)
    return found


def names(text: str, pattern: str) -> list[str]:
    match = re.search(pattern, text, flags=re.DOTALL)
    assert match, pattern
    return re.findall(r"\bk[A-Z]\w+", match[1])


def test_every_page_with_cpp_is_checked() -> None:
    assert {path.stem for path in PAGES if "```cpp" in path.read_text()} == set(TABLES)


@pytest.mark.parametrize("name", TABLES)
def test_the_tables_of_a_page_are_ours_with_one_more_entry(name: str) -> None:
    path, added = TABLES[name]
    for pattern in (r"extern const \w+ ([^;]*);", r"kKinds = \{([^}]*)\}"):
        assert names(one(name, "table"), pattern) == [*names((ROOT / path).read_text(), pattern), added]


def test_the_sources_and_tests_of_the_pages_compile(tmp_path: Path) -> None:
    """All in one file, since most of the time goes to the headers that they share."""
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    parts = []
    for name in TABLES:
        test = one(name, "test")
        if "#include" not in test:  # it extends the sensors' tests
            before, end, after = (
                (ROOT / "tests/cpp/sensors/test_sensors.cpp").read_text().rpartition("}  // namespace\n")
            )
            test = before + test + end + after
        parts += [one(name, "source"), test]
    (tmp_path / "all.cpp").write_text("\n".join(parts))
    command = [compiler, "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", *INCLUDES, tmp_path / "all.cpp"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stderr


def test_the_python_of_the_added_sonar_is_a_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Calling it needs the kind in C++, but its names and table entry do not."""
    source = next(block for block in blocks(page_named("add-a-sonar"), "python") if block.startswith('"""'))
    (tmp_path / "echo_sounder.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    assert importlib.import_module("echo_sounder").KIND.model.kind == "echo_sounder"
