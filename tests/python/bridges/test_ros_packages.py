"""`uwsim ros package`: its definitions have the hashes that uwsim announces, and its folder is whole or as it was."""

import importlib
import os
import re
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from ruamel.yaml import YAML
from typer.testing import CliRunner

from uwsim import Simulator
from uwsim.bridges.cli.graph_options import GraphOptions
from uwsim.bridges.cli.ros import package
from uwsim.bridges.ros1.raw_types import raw_type
from uwsim.bridges.ros1.rospy_module import DEBIAN
from uwsim.bridges.ros2.graph import endpoint_data
from uwsim.bridges.ros_packages import ros_packages, write_sealed
from uwsim.channels import Table
from uwsim.channels.ros.own_types import OWN_TYPES
from uwsim.cli.program import app


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    package(tmp_path / "made")
    return tmp_path / "made"


def written(folder: Path, ros: int) -> dict[str, str]:
    """Return the written definitions by the types' names."""
    files = sorted((folder / f"ros{ros}/uwsim_msgs/msg").glob("*.msg"))
    return {f"uwsim_msgs/msg/{path.stem}": path.read_text() for path in files}


def test_definitions_for_ros_2_have_the_announced_hashes(folder: Path) -> None:
    found = written(folder, 2)
    assert found.keys() == OWN_TYPES.keys()
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in found.items():
        store.register(get_types_from_msg(text, name))
    for name in found:
        assert f"typehash={store.hash_rihs01(name)};".encode() == endpoint_data(name, "jazzy")
        assert store.hash_rihs01(name) in (folder / "README.md").read_text()


def test_definitions_for_ros_1_have_the_announced_checksums(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path, str(DEBIAN)])
    loader: Any = pytest.importorskip("genmsg.msg_loader")
    gentools, context = importlib.import_module("genmsg.gentools"), loader.MsgContext.create_default()

    def load(name: str, text: str) -> Any:
        """Load a definition with genmsg, and what it contains with the definitions of Debian's packages."""
        spec = loader.load_msg_from_string(context, text, name)
        for contained in {kind.partition("[")[0] for kind in spec.types if "/" in kind}:
            if not context.is_registered(contained):
                package, short = contained.split("/")
                theirs = getattr(importlib.import_module(f"{package}.msg"), short)._full_text
                load(contained, theirs.partition("\n====")[0])
        return spec

    for name, text in written(folder, 1).items():
        checksum = gentools.compute_md5(context, load(name.replace("/msg/", "/"), text))
        assert checksum == raw_type(name)._md5sum  # type: ignore[attr-defined]
        assert checksum in (folder / "README.md").read_text()


@pytest.mark.parametrize("ros", [1, 2])
def test_packages_name_every_file_and_dependency_that_they_use(folder: Path, ros: int) -> None:
    messages, bringup = (folder / f"ros{ros}" / name for name in ("uwsim_msgs", "uwsim_bringup"))
    texts = [*OWN_TYPES.values(), *(path.read_text() for path in messages.glob("action/*"))]
    used = set(re.findall(r"^(\w+)/", "\n".join(texts), flags=re.MULTILINE))
    manifest = ElementTree.parse(messages / "package.xml")
    assert {element.text for element in manifest.iter("depend")} == used
    build = (messages / "CMakeLists.txt").read_text()
    files = {path.name for kind in ("msg", "srv", "action") for path in messages.glob(f"{kind}/*")}
    assert set(re.findall(r"(\w+\.(?:msg|srv|action))$", build, flags=re.MULTILINE)) == files
    assert ({"Step.srv", "FlyPath.action"} <= files) == (ros == 2)
    assert f"DEPENDENCIES {' '.join(sorted(used))})" in build
    launch = ElementTree.parse(next(bringup.glob("launch/uwsim.launch*")))
    assert (folder / f"ros{ros}/uwsim_description/urdf/rov.urdf").is_file()
    runs = {element.text for element in ElementTree.parse(bringup / "package.xml").iter("exec_depend")}
    assert {node.attrib["pkg"] for node in launch.iter("node")} == runs
    assert "uwsim_bringup)/rviz/uwsim.rviz" in str(launch.find("node[1]").attrib["args"])  # type: ignore[union-attr]
    sys.path.append(str(DEBIAN))
    try:
        parser: Any = pytest.importorskip("catkin_pkg.package")
        paths = (folder / f"ros{ros}").iterdir()
        names = {parser.parse_package(str(path)).name for path in paths}
        assert names == {"uwsim_msgs", "uwsim_description", "uwsim_bringup"}
    finally:
        sys.path.remove(str(DEBIAN))


def test_rviz_and_octomap_server_subscribe_to_our_topics(folder: Path) -> None:
    offered = {f"/{one.name}": one.type for one in Table(Simulator("pool"), wire="standard").channels}
    for ros in (1, 2):
        bringup = folder / f"ros{ros}/uwsim_bringup"
        configuration = YAML(typ="safe").load((bringup / "rviz/uwsim.rviz").read_text())
        assert [panel["Name"] for panel in configuration["Panels"]] == ["Displays"], "more panels would cover the view"
        assert configuration["Window Geometry"]["Width"] >= 1200
        displays = configuration["Visualization Manager"]["Displays"]
        shown = [(one["Class"], one.get("Topic", one.get("Image Topic"))) for one in displays]
        topics = [(kind, topic if ros == 1 else topic["Value"]) for kind, topic in shown if topic]
        assert len(topics) == 4
        model = next(one for one in displays if one["Class"].endswith("/RobotModel"))
        described = "robot_description" if ros == 1 else "/robot_description"
        assert described in (model.get("Robot Description"), model.get("Description Topic", {}).get("Value"))
        assert {offered[topic].rpartition("/")[2] for _, topic in topics} == {
            kind.partition("/")[2] for kind, _ in topics
        }
        launch = ElementTree.parse(next(bringup.glob("launch/uwsim.launch*")))
        assert [offered[element.attrib["to"]] for element in launch.iter("remap")] == ["sensor_msgs/msg/PointCloud2"]


@pytest.mark.parametrize("ros", [1, 2])
def test_the_launch_file_starts_the_simulator_with_options_that_it_has(folder: Path, ros: int) -> None:
    bringup = folder / f"ros{ros}/uwsim_bringup"
    launch = ElementTree.parse(next(bringup.glob("launch/simulate.launch*")))
    defaults = {element.attrib["name"]: element.attrib["default"] for element in launch.findall("arg")}
    assert defaults.keys() >= {"scenario", "speed", "namespace", "rviz", "params_file"}
    assert ("rmw" in defaults) == (ros == 2)
    share = {"find uwsim_bringup": str(bringup), "find-pkg-share uwsim_bringup": str(bringup)}
    values = {f"{kind} {name}": value for kind in ("arg", "var") for name, value in defaults.items()} | share

    def filled(text: str) -> str:
        for _ in range(2):  # a default may contain another
            text = re.sub(r"\$\(([^)]*)\)", lambda found: values[found[1]], text)
        return text

    if ros == 1:
        node = launch.find("node")
        assert node is not None and os.access(bringup / "scripts" / node.attrib["type"], os.X_OK)
        words = filled(node.attrib["args"]).split()
    else:
        executable = launch.find("executable")
        assert executable is not None
        program, command, *words = filled(executable.attrib["cmd"]).split()
        assert (program, command) == ("uwsim", "serve")
    assert not any(word.endswith("=") for word in words), "an empty value is refused"
    assert f"--ros{ros}" in words
    of_any_ros = [word for word in words if not word.startswith(("--ros", "--rmw"))]
    refused = "--record-topic=x"  # once all options have been read
    error = CliRunner().invoke(app, ["serve", *of_any_ros, refused]).exception
    assert str(error) == "--record-topic: needs --record"


def test_parameters_are_set_before_the_start_or_refused_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    options = GraphOptions(params_file=path)
    path.write_text("rov: {mass_kg: 250}\nrov.drag.linear.surge: 61\n")
    with Simulator("pool") as sim:
        options.apply(options.parameters("uwsim"), sim)
        assert (sim.parameters["rov.mass_kg"], sim.parameters["rov.drag.linear.surge"]) == (250, 61)
        path.write_text(
            "/**:\n  ros__parameters: {use_sim_time: true}\n/a/uwsim:\n  ros__parameters: {rov.mass_kg: -1}\n"
        )
        assert options.parameters("b/uwsim") == {}
        with pytest.raises(ValueError, match=r"--params-file .*mine.yaml: .*mass_kg = -1"):
            options.apply(options.parameters("a/uwsim"), sim)
        assert sim.parameters["rov.mass_kg"] == 250
    path.write_text("/other:\n  ros__parameters: {rov.mass_kg: 1}\n")
    with pytest.raises(ValueError, match=r"mine.yaml: must have 'ros__parameters' for the node /uwsim"):
        options.parameters("uwsim")


def test_a_folder_is_replaced_only_as_we_left_it(folder: Path) -> None:
    write_sealed(folder, {"a/b": "new"})
    assert sorted(path.name for path in folder.rglob("*")) == ["a", "b", "uwsim.sha256"]
    (folder / "a/b").write_text("edited")
    (folder.parent / "other").mkdir()
    (folder.parent / "other/mine").touch()
    (folder.parent / "file").touch()
    for name, reason in (
        ("made", "'a/b' is not as uwsim wrote it"),
        ("other", "'mine' is not"),
        ("file", "not a folder"),
    ):
        with pytest.raises(OSError, match=f"--out .*{name}: .*{reason}"):
            write_sealed(folder.parent / name, ros_packages())
    assert (folder / "a/b").read_text() == "edited"
    assert sorted(path.name for path in folder.parent.iterdir()) == ["file", "made", "other"]


def test_an_interrupted_write_leaves_the_folder_as_it_was(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = sorted(os.walk(folder))
    written: list[str] = []

    def full(path: Path, text: str, **options: Any) -> None:
        if len(written) == 3:
            raise OSError(28, "No space left on device")
        written.append(text)

    monkeypatch.setattr(Path, "write_text", full)
    for name in ("made", "absent"):
        written.clear()
        with pytest.raises(OSError, match=f"--out .*{name}: cannot be written: No space left"):
            write_sealed(folder.parent / name, ros_packages())
    assert sorted(os.walk(folder)) == before and [path.name for path in folder.parent.iterdir()] == ["made"]
