"""Generate assets/foxglove/uwsim.json, the layout that the Foxglove app imports: 3D, cameras, values, steering."""

import json
from pathlib import Path

import foxglove.layouts as fl

TARGET = Path(__file__).parents[2] / "assets/foxglove/uwsim.json"


def visible(**settings: object) -> fl.BaseRendererSceneUpdateTopicSettings:
    """Return settings that make a scene visible."""
    return fl.BaseRendererSceneUpdateTopicSettings(visible=True, **settings)


def camera(topic: str) -> fl.ImagePanel:
    """Return an image panel for one camera."""
    return fl.ImagePanel(config=fl.ImageConfig(image_mode=fl.ImageModeConfig(image_topic=topic)))


def plot(title: str, *values: str) -> fl.PlotPanel:
    """Return a panel that plots values over time."""
    return fl.PlotPanel(title=title, config=fl.PlotConfig(paths=[fl.PlotSeries(value=value) for value in values]))


def row(*panels: tuple[float, object]) -> fl.SplitContainer:
    """Place panels side by side, with relative widths."""
    return fl.SplitContainer(
        direction="row", items=[fl.SplitItem(proportion=share, content=panel) for share, panel in panels]
    )


def column(*panels: tuple[float, object]) -> fl.SplitContainer:
    """Stack panels vertically, with relative heights."""
    return fl.SplitContainer(
        direction="column", items=[fl.SplitItem(proportion=share, content=panel) for share, panel in panels]
    )


space = fl.ThreeDeePanel(
    config=fl.ThreeDeeConfig(
        fixed_frame="world",
        follow_tf="base_link",
        follow_mode="follow-position",
        camera_state=fl.ThreeDeeCameraState(distance=40.0, phi=60.0, theta_offset=45.0, perspective=True),
        topics={
            **{f"/scene/{name}": visible() for name in ("lake", "vehicles", "track", "map")},
            "/scan": fl.BaseRendererLaserScanTopicSettings(visible=True, flat_color="#00e0ff", color_mode="flat"),
        },
    )
)
steering = fl.TeleopPanel(
    config=fl.TeleopConfig(
        topic="/cmd_vel",
        publish_rate=10.0,
        up_button=fl.TeleopButton(field="linear-x", value=0.5),
        down_button=fl.TeleopButton(field="linear-x", value=-0.5),
        left_button=fl.TeleopButton(field="angular-z", value=0.3),
        right_button=fl.TeleopButton(field="angular-z", value=-0.3),
        auto_send_stop_on_release=True,
    )
)
undock = fl.ServiceCallPanel(config=fl.ServiceCallConfig(service_name="/undock", request_payload="{}"))

layout = fl.Layout(
    content=row(
        (3, column((3, space), (1, plot("Depth and speed", "/depth.data", "/odom.twist.twist.linear.x")))),
        (
            2,
            column(
                (2, camera("/camera/front/image_raw/compressed")),
                (2, camera("/camera/down/image_raw/compressed")),
                (2, row((2, steering), (1, undock))),
            ),
        ),
    )
)
TARGET.parent.mkdir(exist_ok=True)
TARGET.write_text(json.dumps(json.loads(layout.to_json()), indent=2) + "\n", encoding="utf-8")
