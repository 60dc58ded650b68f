"""Sockets: entry points by group, uwsim's own first; a stranger's broken entry is reported and left out."""

import json
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from uwsim.base import sockets
from uwsim.base.sockets import Entry, SocketWarning, load, load_all, registered


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of packages, in place of the installed ones: uwsim with two kinds, to which a test may add others."""
    monkeypatch.setattr("sys.path", [str(tmp_path), str(tmp_path / "no such folder")])
    install(tmp_path, "uwsim-0.3.0.dist-info", OWN)
    _forget()
    yield tmp_path
    _forget()


def _forget() -> None:
    for each in (registered, load_all, sockets._loaded, sockets._installed):
        each.cache_clear()


def install(folder: Path, name: str, text: str) -> None:
    (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / name / "entry_points.txt").write_text(text)


OWN = "[console_scripts]\nuwsim = uwsim.cli:main\n[uwsim.kinds]\nb = json:loads\na = json:dumps\n"


def test_own_entries_come_first_in_their_order_and_then_those_of_others_by_name(installed: Path) -> None:
    install(installed, "Some_Kinds-2.0.dist-info", "[uwsim.kinds]\n# one more\nd=json.decoder:JSONDecoder.decode [x]\n")
    install(installed, "more.egg-info", "[ uwsim.kinds ]\nc = json:load\n[uwsim.others]\ne = json:dump")
    (installed / "none-1.0.dist-info").mkdir()
    assert [(each.name, each.package) for each in registered("uwsim.kinds").values()] == [
        ("b", "uwsim"), ("a", "uwsim"), ("c", "more"), ("d", "some-kinds")
    ]  # fmt: skip
    assert load("uwsim.kinds", "d") is json.JSONDecoder.decode
    assert list(load_all("uwsim.kinds").values()) == [json.loads, json.dumps, json.load, json.JSONDecoder.decode]
    with pytest.raises(ValueError, match=r"uwsim\.new: uwsim's installation lists none: .* Install it again"):
        registered("uwsim.new")


def test_a_name_that_is_taken_is_reported_and_left_out(installed: Path) -> None:
    install(installed, "greedy-1.dist-info", "[uwsim.kinds]\na = json:load")
    with pytest.warns(SocketWarning, match="uwsim.kinds: 'a' of greedy: the name is taken by uwsim"):
        assert load("uwsim.kinds", "a") is json.dumps


def test_a_broken_entry_is_reported_and_left_out(installed: Path) -> None:
    def number(name: str, found: Any) -> int:
        if name == "odd":
            raise ValueError("must be even")
        return 2

    install(installed, "broken-1.dist-info", "[uwsim.kinds]\nodd = json:load\ngone = json:gone")
    with pytest.warns(SocketWarning) as said:
        assert load_all("uwsim.kinds", number) == {"b": 2, "a": 2}
    assert [str(each.message) for each in said] == [
        "uwsim.kinds: 'gone' of broken (json:gone): cannot be used: AttributeError: module 'json' has no attribute "
        "'gone'",
        "uwsim.kinds: 'odd' of broken (json:load): cannot be used: ValueError: must be even",
    ]
    with pytest.raises(ValueError, match="'odd' of broken"):
        load("uwsim.kinds", "odd", number)
    with pytest.raises(ValueError, match="'oddd': must be one of b, a, gone, odd; did you mean 'odd'"):
        load("uwsim.kinds", "oddd")


def test_an_error_of_uwsims_own_is_not_hidden(installed: Path) -> None:
    install(installed, "uwsim-0.3.0.dist-info", "[uwsim.kinds]\ngone = json:gone")
    with pytest.raises(AttributeError):
        load_all("uwsim.kinds")


def test_a_part_of_uwsim_that_is_not_installed_is_reported_and_left_out(installed: Path) -> None:
    install(installed, "uwsim-0.3.0.dist-info", "[uwsim.kinds]\nhere = json:load\ngone = uwsim.nowhere.room:x")
    with pytest.warns(SocketWarning, match="'gone' of uwsim .*: cannot be used: .*No module named 'uwsim.nowhere'"):
        assert list(load_all("uwsim.kinds")) == ["here"]


def test_of_a_package_that_is_there_twice_the_first_is_meant(installed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(installed / "later", "uwsim-0.2.0.dist-info", "[uwsim.kinds]\nold = json:load")
    monkeypatch.setattr("sys.path", [str(installed), str(installed / "later")])
    assert list(registered("uwsim.kinds")) == ["b", "a"]


def test_an_entry_loads_while_a_thread_imports_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither thread waits with the lock of a module that the other needs: the interpreter would raise an error."""
    package = tmp_path / "slow_package"
    package.mkdir()
    (package / "kind.py").write_text("import slow_package\nNAME = 7\n")
    (package / "__init__.py").write_text("import time\ntime.sleep(0.3)\nfrom slow_package.kind import NAME\n")
    monkeypatch.syspath_prepend(tmp_path)
    found: list[object] = []
    loading = threading.Timer(0.1, lambda: found.append(Entry("kind", "slow_package.kind:NAME", "toy").load()))
    loading.start()
    __import__("slow_package")
    loading.join()
    assert found == [7]
    for name in ("slow_package", "slow_package.kind"):
        sys.modules.pop(name, None)
