"""The RViz configuration for uwsim's standard topics. RViz 1 and 2 use different names of classes and topics."""

from __future__ import annotations

import io
from typing import Any

from ruamel.yaml import YAML

from uwsim.channels.ros.message_types import Ros

FIXED_FRAME, VEHICLE_FRAME = "odom", "base_link"
IMAGE = "/camera/front/image_raw"
CLOUD_DECAY_S = 120.0


def rviz_configuration(ros: Ros) -> str:
    """Return the text of a configuration: vehicle, transforms, odometry, scans, clouds and the front camera."""
    plugins, panels = ("rviz", "rviz") if ros == 1 else ("rviz_default_plugins", "rviz_common")

    def display(kind: str, topic: str | None = None, **settings: Any) -> dict[str, Any]:
        named = {"Class": f"{plugins}/{kind}", "Name": topic or kind, "Enabled": True, "Value": True}
        return named | ({} if topic is None else {"Topic": topic if ros == 1 else _topic(topic)}) | settings

    configuration = {
        # Without a saved state of Qt, RViz stacks all panels at the left, where a wide one (Time) hides the view.
        "Panels": [{"Class": f"{panels}/Displays", "Name": "Displays"}],
        "Window Geometry": {"Width": 1400, "Height": 900, "X": 40, "Y": 40},
        "Visualization Manager": {
            "Class": "",
            "Global Options": {"Fixed Frame": FIXED_FRAME, "Background Color": "16; 36; 56", "Frame Rate": 30},
            "Displays": [
                display("Grid", None, **{"Reference Frame": FIXED_FRAME, "Cell Size": 5, "Plane Cell Count": 40}),
                display("RobotModel") | _described(ros),
                display("TF", None, **{"Show Names": False, "Marker Scale": 1}),
                display("Odometry", "/odom", Keep=100),
                display("LaserScan", "/scan", **{"Size (m)": 0.1}),
                display(
                    "PointCloud2", "/laserPointCloud",
                    **{"Color Transformer": "AxisColor", "Decay Time": CLOUD_DECAY_S, "Size (m)": 0.1},
                ),
                display("Image") | ({"Image Topic": IMAGE} if ros == 1 else {"Topic": _topic(IMAGE)}),
            ],
            "Tools": [{"Class": f"{plugins}/{name}"} for name in ("MoveCamera", "Select", "FocusCamera", "Measure")],
            "Views": {"Current": {
                "Class": f"{plugins}/Orbit", "Name": "Current View", "Target Frame": VEHICLE_FRAME, "Distance": 20,
                "Pitch": 0.6, "Yaw": 3.9,
            }},
        },
    }  # fmt: skip
    text = io.StringIO()
    YAML().dump(configuration, text)
    return text.getvalue()


def _described(ros: Ros) -> dict[str, Any]:
    """Return the source of the URDF: a parameter for RViz 1, a latched topic for RViz 2."""
    if ros == 1:
        return {"Robot Description": "robot_description"}
    return {"Description Source": "Topic", "Description Topic": _topic("/robot_description", "Transient Local")}


def _topic(name: str, durability: str = "Volatile") -> dict[str, Any]:
    """Return RViz 2's subscription to a topic."""
    return {
        "Value": name, "Depth": 10, "History Policy": "Keep Last", "Reliability Policy": "Reliable",
        "Durability Policy": durability,
    }  # fmt: skip
