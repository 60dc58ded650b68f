"""Our messages in distributions older than those that we serve: which have other fields there, and no others."""

import pytest
from rosbags.typesys import Stores, get_typestore

from uwsim.channels.ros.message_types import ros1_typestore, typestore
from uwsim.channels.table import Table
from uwsim.simulator.simulator import Simulator

MELODIC = {
    "geometry_msgs/msg/Pose": "e45d45a5a1ce597b249e23fb30fc871f",
    "geometry_msgs/msg/PoseWithCovarianceStamped": "953b798c0f514ff060a53a3498ce6246",
    "geometry_msgs/msg/Twist": "9f195f881246fdfa2798d1d3eebca84a",
    "geometry_msgs/msg/TwistWithCovarianceStamped": "8927a1a12fb2607ceea095b2dc440a96",
    "geometry_msgs/msg/Wrench": "4f539cf138b23283b520fd271b567936",
    "nav_msgs/msg/Odometry": "cd5e73d190d741a2f92e81eda573aca7",
    "sensor_msgs/msg/BatteryState": "476f837fa6771f6e16e3bf4ef96f8770",
    "sensor_msgs/msg/CameraInfo": "c9a58c1b0b154e0e6da7578cb991d214",
    "sensor_msgs/msg/CompressedImage": "8f7a12909da2c9d3332d540a0977563f",
    "sensor_msgs/msg/FluidPressure": "804dc5cea1c5306d6a2eb80b9833befe",
    "sensor_msgs/msg/Image": "060021388200f6f0f447d0fcd9c64743",
    "sensor_msgs/msg/Imu": "6a62c6daae103f4ff57a132d6f95cec2",
    "sensor_msgs/msg/JointState": "3066dcd76a6cfaef579bd0f34173e9fd",
    "sensor_msgs/msg/LaserScan": "90c7ef2dc6895d81024acba2ac42f369",
    "sensor_msgs/msg/PointCloud2": "1158d486dd51d683ce2f1be655c3c181",
    "sensor_msgs/msg/Range": "c005c34273dc426c67a020a87bc24148",
    "sensor_msgs/msg/Temperature": "ff71b307acdbe7c871a5a6d7ed359100",
}
"""md5 sums by the definitions of common_msgs 1.12.8, Melodic's."""
RANGE = {"sensor_msgs/msg/Range"}


@pytest.fixture(scope="module")
def sent():
    """The types of all topics of two packaged scenarios, and those of the published wire."""
    tables = [Table(Simulator(name)) for name in ("lake", "paper")]
    published = Table(Simulator("paper"), wire="published").channels
    return {each.type for table in tables for each in table.channels}, {each.type for each in published}


def parts_of(kind, types, found):
    """Add a type and those of its fields, at any depth, to `found`."""
    found.add(kind)
    for _, field in types[kind][1]:
        while field[0].name in ("ARRAY", "SEQUENCE"):
            field = field[1][0]
        if field[0].name == "NAME" and field[1] not in found:
            parts_of(field[1], types, found)
    return found


@pytest.mark.parametrize("distribution", ["ELOQUENT", "FOXY", "GALACTIC", "HUMBLE"])
def test_in_older_ros_2_only_ranges_have_other_fields(sent, distribution):
    ours, theirs = typestore().fielddefs, get_typestore(Stores[f"ROS2_{distribution}"]).fielddefs
    differing = {
        kind
        for kind in sent[0] & theirs.keys()
        if any(ours[part][1] != theirs.get(part, ((), ()))[1] for part in parts_of(kind, ours, set()))
    }
    assert differing == RANGE and not differing & sent[1]
    assert sent[1] <= theirs.keys()  # the published wire is the same in all of them


def test_in_melodic_only_the_battery_has_other_fields(sent):
    store = ros1_typestore()
    assert {kind for kind, md5 in MELODIC.items() if store.generate_msgdef(kind)[1] != md5} == {
        "sensor_msgs/msg/BatteryState"
    }
    of_common_msgs = ("geometry_msgs/", "nav_msgs/", "sensor_msgs/")
    assert {kind for kind in sent[1] if kind.startswith(of_common_msgs)} <= MELODIC.keys()
