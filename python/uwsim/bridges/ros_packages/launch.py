"""The launch files: one starts uwsim and includes the other, which displays what a running uwsim publishes."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.channels.ros.message_types import Ros

VIEWERS: dict[Ros, tuple[str, ...]] = {1: ("rviz", "octomap_server"), 2: ("rviz2", "octomap_server")}

DEFAULTS = """\
# Parameters that uwsim sets before it starts; `uwsim scenario parameters lake` lists them.
/**:
  ros__parameters: {}
#   rov.drag.linear.surge: 60.0
"""

SERVE = """\
#!/bin/sh
# Starts uwsim without the arguments that roslaunch adds, such as __name:=uwsim.
for argument; do
  shift
  case $argument in *:=*) ;; *) set -- "$@" "$argument" ;; esac
done
exec uwsim serve "$@"
"""


def simulate(ros: Ros, package: str, scenario: str) -> str:
    """Return the launch file that starts the simulator. package: that of the launch files."""
    value, share = ("arg", "find") if ros == 1 else ("var", "find-pkg-share")
    options = "--joint-frames " + " ".join(
        f"--{name.replace('_', '-')}=$({value} {name})" for name in ("speed", "namespace", "tf", "port", "params_file")
    )
    if ros == 1:
        start = (
            f'<node name="uwsim" pkg="{package}" type="serve" required="true" output="screen"\n'
            f'        args="$(arg scenario) --ros1 {options}"/>'
        )
    else:
        command = f"uwsim serve $(var scenario) --ros2 --rmw=$(var rmw) {options}"
        start = f'<executable output="screen" cmd="{command}"/>'
    about = "doc" if ros == 1 else "description"
    arguments = {
        "scenario": (scenario, "a packaged one, or the path of a YAML file"),
        "speed": ("1", "simulated seconds per second, or max"),
        "namespace": ("/", "of topics, services and frames; the file of RViz has none"),
        "tf": ("truth", "the motion on /tf: truth, odom (the estimate) or none (left to other nodes)"),
        "port": (str(ROSBRIDGE_PORT), "of the rosbridge beside the node; 0 chooses a free one"),
        "params_file": (f"$({share} {package})/config/parameters.yaml", "the parameters to set at the start"),
        **({} if ros == 1 else {"rmw": ("fastrtps", "the middleware: fastrtps, cyclonedds or zenoh")}),
        "rviz": ("true", "whether to start RViz"),
        "octomap": ("false", "whether to build a map with octomap_server"),
    }
    lines = "".join(
        f'  <arg name="{name}" default={quoteattr(default)} {about}="{text}"/>\n'
        for name, (default, text) in arguments.items()
    )
    suffix = "" if ros == 1 else ".xml"
    return f"""<launch>  <!-- starts uwsim, which must be on the PATH, as a ROS {ros} node, and displays it -->
{lines}  {start}
  <include file="$({share} {package})/launch/uwsim.launch{suffix}">
    <arg name="rviz" value="$({value} rviz)"/>
    <arg name="octomap" value="$({value} octomap)"/>
  </include>
</launch>
"""


def display(ros: Ros, package: str) -> str:
    """Return the launch file that displays what a running `uwsim serve` publishes."""
    one = ros == 1
    value, kind, share = ("arg", "type", "find") if one else ("var", "exec", "find-pkg-share")
    clock = '<param name="/use_sim_time" value="true"/>' if one else '<set_parameter name="use_sim_time" value="true"/>'
    viewer, name = VIEWERS[ros][0], ' name="{}"' if one else ""
    return f"""<launch>  <!-- displays what a running uwsim serve publishes as a ROS {ros} node -->
  <arg name="rviz" default="true"/>
  <arg name="octomap" default="false"/>  <!-- whether to build a map from the multibeam -->
  {clock}
  <node if="$({value} rviz)"{name.format("rviz")} pkg="{viewer}" {kind}="{viewer}"
        args="-d $({share} {package})/rviz/uwsim.rviz"/>
  <node if="$({value} octomap)"{name.format("octomap_server")} pkg="octomap_server" {kind}="octomap_server_node">
    <remap from="cloud_in" to="/laserPointCloud"/>
    <param name="frame_id" value="odom"/>
  </node>
</launch>
"""
