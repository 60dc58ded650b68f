"""An import of a robot's description names what it leaves out, and keeps the errors of its sensors."""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from uwsim.exchange.robots.robot import Description
from uwsim.exchange.robots.sdf import read_sdf
from uwsim.exchange.robots.stonefish import read_stonefish
from uwsim.exchange.robots.urdf import read_urdf

DATA = Path(__file__).parents[1] / "data" / "robots"


@pytest.mark.parametrize(
    ("name", "read", "dropped"),
    [
        ("glider.sdf", read_sdf, {"nose", "crate", "l"}),  # a sensor; a model that moves, and its link
        ("sled.urdf", read_urdf, set()),
        ("robot.scn", read_stonefish, set()),
    ],
)
def test_what_no_reader_asks_for_is_named(
    name: str, read: Callable[[Path], Description], dropped: set[str], tmp_path: Path
) -> None:
    """An element and an attribute without a meaning, added to every element but those with a text."""
    root = ElementTree.parse(DATA / name).getroot()
    names: list[str | None] = []
    for element in list(root.iter()):
        if len(element) or not (element.text or "").strip():
            ElementTree.SubElement(element, f"foo_{len(names)}_")
            element.set(f"bar_{len(names)}_", "1")
            names.append(element.get("name"))
    ElementTree.ElementTree(root).write(tmp_path / name)
    notes = "\n".join(map(str, read(tmp_path / name).notes))
    for word in ("foo", "bar"):
        assert {at for k, at in enumerate(names) if f"{word}_{k}_" not in notes} == dropped


IMU = """<gazebo><plugin name="imu" filename="libuuv_gazebo_ros_imu_plugin.so"><link_name>base</link_name>
  <update_rate>50</update_rate><gyroscope_noise_density>0.0003394</gyroscope_noise_density>
  <gyroscope_random_walk>0.000038785</gyroscope_random_walk>
  <gyroscope_bias_correlation_time>1000</gyroscope_bias_correlation_time>
  <accelerometer_turn_on_bias_sigma>0.196</accelerometer_turn_on_bias_sigma></plugin></gazebo></robot>"""


def test_an_imu_of_uuv_simulator_keeps_its_errors(tmp_path: Path) -> None:
    """A bias that decays with T and is driven by a random walk s has a standard deviation of s sqrt(T / 2)."""
    (tmp_path / "sled.urdf").write_text((DATA / "sled.urdf").read_text().replace("</robot>", IMU))
    (robot,) = read_urdf(tmp_path / "sled.urdf").robots
    channels = robot.sensors["imu"]["channels"]
    gyro = channels["angular_velocity"]
    assert (gyro["density"], gyro["bias_time_s"]) == (0.0003394, 1000.0)
    assert gyro["bias_std"] == pytest.approx(0.000038785 * np.sqrt(500.0))
    assert channels["linear_acceleration"]["turn_on_std"] == 0.196
