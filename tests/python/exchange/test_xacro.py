"""xacro's expressions by a grammar of ours: a description is data, and reads no file outside its checkout."""

import os
from pathlib import Path

import pytest

from uwsim.exchange.robots.expressions import value_of
from uwsim.exchange.robots.urdf import expanded, read_urdf

pytestmark = pytest.mark.skipif(not pytest.importorskip("xacro", reason="the extra robots"), reason="the extra robots")

ROBOT = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="a">{}</robot>'
CLASSES = "().__class__.__base__.__subclasses__()"
WITH = '<xacro:property name="p" value="${{{}}}"/><link name="${{p}}"/>'


def robot(folder: Path, text: str) -> Path:
    (folder / "bot").mkdir()
    (folder / "bot" / "a.urdf.xacro").write_text(ROBOT.format(text))
    (folder / "bot" / "sizes.yaml").write_text("side: !degrees 180\nnames: [port, star]\nmass: {dry: 2 }\n")
    (folder / "bot" / "part.xacro").write_text(ROBOT.format('<link name="part"/>'))
    return folder / "bot" / "a.urdf.xacro"


@pytest.mark.parametrize(
    "text, value",
    [
        ("2*0.4", "0.8"),
        ("-2**2 + 7 // 2 % 3", "-4"),
        ("1 if 3 > 2 >= 2 and not False else 0", "1"),
        ("math.pi == pi and round(cos(0))", "1"),
        ("'a' + str(len([1, 2])) + 'x y'.split()[1][0:1]", "a2y"),
        ("xacro.load_yaml('sizes.yaml').mass.dry + max(1, 2)", "4"),
        ("load_yaml('sizes.yaml')['side'] == pi", "True"),
        ("list(map(float, '1 2'.split()))[1]", "2.0"),
        ("', '.join(load_yaml('sizes.yaml')['names'])", "port, star"),
        ("dict(a=1).get('b', 'c' in {'c': 1})", "True"),
    ],
)
def test_expressions_of_robots_have_their_values(text: str, value: str, tmp_path: Path) -> None:
    path = robot(tmp_path, WITH.format(text.replace("{", "dict(").replace("}", ")").replace("dict('c': 1)", "['c']")))
    assert f'<link name="{value}"/>'.encode() in expanded(path, {})


@pytest.mark.parametrize(
    "text, words",
    [
        (WITH.format(f"(lambda: {CLASSES})()"), "Lambda: is not part of expressions"),
        (WITH.format(CLASSES), "Attribute: is not part of expressions"),
        (WITH.format("[x for x in (1, 2)]"), "ListComp: is not part of expressions"),
        (WITH.format("f'!s'"), "JoinedStr: is not part of expressions"),
        (WITH.format("''.format(1)"), "Attribute: is not part of expressions"),
        (WITH.format("python.type(1)"), "is not part of expressions"),
        (WITH.format("load_yaml('odd.yaml')"), "Lambda: is not part of expressions"),
        (WITH.format("load_yaml('/etc/passwd')"), "'/etc/passwd': is outside"),
        (WITH.format("load_yaml('../secret')"), "secret': is outside"),
        (WITH.format("load_yaml('fifo')"), "it is no regular file"),
        (WITH.format("10**10**10"), "an operator makes more than"),
        (WITH.format("'a'*10**9"), "an operator makes more than"),
        ('<a b="$(env HOME)"/>', "the environment is not read"),
        ("<a b=\"$(eval 'a'.__class__)\"/>", "is not part of expressions"),
        ('<xacro:include filename="fifo"/>', "it is no regular file"),
        ('<xacro:include filename="/dev/ptmx"/>', "/dev/ptmx': is outside"),
        ('<xacro:include filename="../secret"/>', "secret': is outside"),
        ('<xacro:include filename="$(find ../..)/a.xacro"/>', "is outside"),
        ('<xacro:include filename="doctype.xacro"/>', "has a DOCTYPE"),
        ('<xacro:macro name="a"><xacro:a/></xacro:macro><xacro:a/>', "recursion"),
    ],
)
def test_a_description_runs_nothing_and_reads_its_checkout_alone(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("word")
    path = robot(tmp_path, text)
    (path.parent / "odd.yaml").write_text(f'a: !degrees "(lambda: {CLASSES})()"')
    (path.parent / "doctype.xacro").write_text("<!DOCTYPE robot><robot/>")
    os.mkfifo(path.parent / "fifo")
    with pytest.raises(ValueError, match=words) as refused:
        read_urdf(path)
    assert "word" not in str(refused.value) and "\n" not in str(refused.value)


def test_globs_optional_files_and_defaults_are_those_of_xacro(tmp_path: Path) -> None:
    text = '<xacro:include filename="p*.xacro"/><xacro:include filename="absent" optional="true"/>'
    text += '<xacro:include filename="../s*"/><a b="$(optenv HOME none) $(eval 2*3)"/>'
    (tmp_path / "secret").write_text("<a/>")
    made = expanded(robot(tmp_path, text), {})
    assert b'<link name="part"/>' in made and b'b="none 6"' in made and made.count(b"<a ") == 1


def test_a_package_that_is_installed_by_links_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As by colcon's --symlink-install."""
    source, share = tmp_path / "src" / "deep" / "parts", tmp_path / "install" / "share" / "parts"
    for folder in (source, share):
        folder.mkdir(parents=True)
    (source / "package.xml").write_text("<package><name>parts</name></package>")
    (source / "p.xacro").write_text(ROBOT.format('<link name="part"/>'))
    for name in ("package.xml", "p.xacro"):
        (share / name).symlink_to(source / name)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    (tmp_path / "a" / "b" / "c" / "d" / "e" / "f").mkdir(parents=True)
    path = robot(tmp_path / "a/b/c/d/e/f", '<xacro:include filename="$(find parts)/p.xacro"/>')
    assert b'<link name="part"/>' in expanded(path, {})


def test_a_package_s_manifest_is_a_regular_file(tmp_path: Path) -> None:
    path = robot(tmp_path, '<xacro:include filename="$(find other)/part.xacro"/>')
    os.mkfifo(path.parent / "package.xml")
    with pytest.raises(ValueError, match="package 'other' is neither around the file"):
        read_urdf(path)


def test_names_are_those_that_are_given() -> None:
    assert value_of("a.b + c[0]", {"a": {"b": 1}, "c": [2]}, ()) == 3
    for text, error in (("d", NameError), ("len('a')", NameError), ("a(1)", ValueError), ("1 +", ValueError)):
        with pytest.raises(error):
            value_of(text, {"a": len}, ())
