"""The bridges that options request: which commands have them, and what is refused before anything is built."""

import subprocess
import sys
from types import SimpleNamespace

import pytest

from uwsim.base.options import OptionError, WithoutEffectError
from uwsim.bridges.ardusub.options import ArduSubOptions
from uwsim.bridges.requested import Bridges, PlayedBridges
from uwsim.cli.autopilots import Autopilots

NEED_LIVE = {
    "dvl_a50", "imc", "imc_id", "imc_port", "imc_rate", "imc_rpm", "imc_sends", "mavlink", "mavlink_pictures", "moos",
    "moos_control", "moos_elevator", "moos_name", "moos_nav", "moos_rate", "moos_reports", "moos_shore", "nmea",
    "nmea_rate", "ping1d", "ping360", "video", "video_camera",
}  # fmt: skip


def test_a_recording_is_offered_to_all_bridges_but_those_that_need_a_simulator() -> None:
    assert Bridges.flags().keys() - PlayedBridges.flags().keys() == NEED_LIVE
    assert list(Bridges.flags())[:3] == ["ros2", "ros_distro", "ros_domain_id"]


def test_only_what_is_requested_is_opened() -> None:
    assert Bridges().names == []
    assert Bridges(foxglove=True, video="5600").names == ["foxglove", "video"]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"rmw": "zenoh"}, "--rmw: needs --ros2"),
        ({"ros2": True, "ros_peer": ("host",)}, "--ros-peer: needs --ros-reach subnet"),
        ({"video_camera": "front"}, "--video-camera: needs --video"),
    ],
)
def test_an_option_without_effect_is_refused(values: dict[str, object], message: str) -> None:
    with pytest.raises(WithoutEffectError, match=message):
        Bridges(**values)


def test_a_wrong_address_and_a_rival_option_are_refused_before_anything_is_built() -> None:
    with pytest.raises(ValueError, match="video = 'x': must be"):
        Bridges(video="x").prepare()
    with pytest.raises(ValueError, match="--mavlink: cannot be given with --ardusub: the firmware speaks MAVLink"):
        Bridges(mavlink="udpout").prepare(["ardusub"])


def test_one_of_several_autopilots_flies() -> None:
    assert Autopilots(ardusub=True, ardusub_port=0).only == ArduSubOptions(ardusub=True, ardusub_port=0)
    assert Autopilots().only is None
    two = Bridges(foxglove=True, video="5600")
    with pytest.raises(OptionError, match="--video: cannot be given with --foxglove"):
        _ = two.only


@pytest.mark.parametrize(("name", "value"), [("mavlink", "udpout"), ("video", "5600")])
def test_what_does_not_cross_the_link_is_refused_with_a_link(name: str, value: str) -> None:
    chosen = Bridges(**{name: value})
    chosen.prepare()
    chosen.check(SimpleNamespace(link=None))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=f"--{name}: does not cross the link"):
        chosen.check(SimpleNamespace(link="a modem"))  # type: ignore[arg-type]


def test_flags_are_listed_without_importing_a_bridge() -> None:
    code = "import sys; from uwsim.bridges.requested import Bridges; Bridges.flags(); print('numpy' in sys.modules)"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "False\n"
