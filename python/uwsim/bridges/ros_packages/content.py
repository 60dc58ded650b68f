"""The files of the packages uwsim_msgs and uwsim_bringup, for catkin (ROS 1) and ament (ROS 2)."""

from __future__ import annotations

from importlib.metadata import version

from uwsim.bridges.ros_packages.rviz import rviz_configuration
from uwsim.channels.ros.action_types import ACTION_TYPES, load_action_types
from uwsim.channels.ros.cdr import schema
from uwsim.channels.ros.message_types import Ros, fields, ros1_typestore
from uwsim.channels.ros.own_types import OWN_TYPES
from uwsim.channels.ros.service_types import SERVICE_TYPES

MESSAGES, BRINGUP = "uwsim_msgs", "uwsim_bringup"
OWN_SERVICES = [name for name in SERVICE_TYPES if name.startswith(f"{MESSAGES}/")]
OWN_ACTIONS = [name for name in ACTION_TYPES if name.startswith(f"{MESSAGES}/")]
VIEWERS: dict[Ros, tuple[str, ...]] = {1: ("rviz", "octomap_server"), 2: ("rviz2", "octomap_server")}


def ros_packages() -> dict[str, str]:
    """Return the text of each file, keyed by path: ros1/ and ros2/ with the two packages, and a README."""
    files = {"README.md": _readme()}
    for ros in (1, 2):
        messages, bringup = f"ros{ros}/{MESSAGES}", f"ros{ros}/{BRINGUP}"
        for name, text in OWN_TYPES.items():
            files[f"{messages}/msg/{_short(name)}.msg"] = text
        for name in OWN_SERVICES if ros == 2 else ():  # ROS 1 supports neither defaults nor bounded lists
            files[f"{messages}/srv/{_short(name)}.srv"] = SERVICE_TYPES[name]
        for name in OWN_ACTIONS if ros == 2 else ():
            files[f"{messages}/action/{_short(name)}.action"] = ACTION_TYPES[name]
        files[f"{messages}/package.xml"] = _manifest(
            ros, MESSAGES, "Messages of the simulator uwsim.", _of_messages(ros)
        )
        files[f"{messages}/CMakeLists.txt"] = _build_of_messages(ros)
        viewers = "".join(f"  <exec_depend>{name}</exec_depend>\n" for name in VIEWERS[ros])
        files[f"{bringup}/package.xml"] = _manifest(
            ros, BRINGUP, "Displays uwsim's topics, and maps from them.", viewers
        )
        files[f"{bringup}/CMakeLists.txt"] = _build_of_bringup(ros)
        files[f"{bringup}/launch/uwsim.launch{'' if ros == 1 else '.xml'}"] = _launch(ros)
        files[f"{bringup}/rviz/uwsim.rviz"] = rviz_configuration(ros)
    return files


def _short(name: str) -> str:
    return name.rpartition("/")[2]


def _dependencies(ros: Ros) -> list[str]:
    """Return the packages whose messages ours contain."""
    names = list(OWN_TYPES)
    if ros == 2 and OWN_ACTIONS:
        load_action_types()
        names += [f"{name}_{part}" for name in OWN_ACTIONS for part in ("Goal", "Result", "Feedback")]
    kinds = (field.kind for name in names for field in fields(name, ros))
    return sorted({kind.base.partition("/")[0] for kind in kinds if kind.is_message} - {MESSAGES})


def _manifest(ros: Ros, name: str, description: str, dependencies: str) -> str:
    build = "catkin" if ros == 1 else "ament_cmake"
    export = "" if ros == 1 else "  <export><build_type>ament_cmake</build_type></export>\n"
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>{version("uwsim")}</version>
  <description>{description}</description>
  <maintainer email="uwsim@example.com">the uwsim authors</maintainer>
  <license>MIT</license>
  <buildtool_depend>{build}</buildtool_depend>
{dependencies}{export}</package>
"""


def _of_messages(ros: Ros) -> str:
    contained = "".join(f"  <depend>{name}</depend>\n" for name in _dependencies(ros))
    if ros == 1:
        return (
            f"{contained}  <build_depend>message_generation</build_depend>\n"
            "  <exec_depend>message_runtime</exec_depend>\n"
        )
    return (
        f"{contained}  <buildtool_depend>rosidl_default_generators</buildtool_depend>\n"
        "  <exec_depend>rosidl_default_runtime</exec_depend>\n"
        "  <member_of_group>rosidl_interface_packages</member_of_group>\n"
    )


def _build_of_messages(ros: Ros) -> str:
    packages = " ".join(_dependencies(ros))
    names = "".join(f"  {_short(name)}.msg\n" for name in OWN_TYPES)
    services = "".join(f"  srv/{_short(name)}.srv\n" for name in OWN_SERVICES)
    services += "".join(f"  action/{_short(name)}.action\n" for name in OWN_ACTIONS)
    if ros == 1:
        return f"""cmake_minimum_required(VERSION 3.0.2)
project({MESSAGES})
find_package(catkin REQUIRED COMPONENTS message_generation {packages})
add_message_files(FILES
{names})
generate_messages(DEPENDENCIES {packages})
catkin_package(CATKIN_DEPENDS message_runtime {packages})
"""
    found = "".join(
        f"find_package({name} REQUIRED)\n" for name in ("ament_cmake", "rosidl_default_generators", *_dependencies(ros))
    )
    return f"""cmake_minimum_required(VERSION 3.8)
project({MESSAGES})
{found}rosidl_generate_interfaces(${{PROJECT_NAME}}
{names.replace("  ", "  msg/")}{services}  DEPENDENCIES {packages})
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def _build_of_bringup(ros: Ros) -> str:
    if ros == 1:
        return f"""cmake_minimum_required(VERSION 3.0.2)
project({BRINGUP})
find_package(catkin REQUIRED)
catkin_package()
install(DIRECTORY launch rviz DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})
"""
    return f"""cmake_minimum_required(VERSION 3.8)
project({BRINGUP})
find_package(ament_cmake REQUIRED)
install(DIRECTORY launch rviz DESTINATION share/${{PROJECT_NAME}})
ament_package()
"""


def _launch(ros: Ros) -> str:
    one = ros == 1
    value, kind, share = ("arg", "type", "find") if one else ("var", "exec", "find-pkg-share")
    clock = '<param name="/use_sim_time" value="true"/>' if one else '<set_parameter name="use_sim_time" value="true"/>'
    viewer, name = VIEWERS[ros][0], ' name="{}"' if one else ""
    return f"""<launch>  <!-- displays what a running uwsim serve publishes as a ROS {ros} node -->
  <arg name="rviz" default="true"/>
  <arg name="octomap" default="false"/>  <!-- whether to build a map from the multibeam -->
  {clock}
  <node if="$({value} rviz)"{name.format("rviz")} pkg="{viewer}" {kind}="{viewer}"
        args="-d $({share} {BRINGUP})/rviz/uwsim.rviz"/>
  <node if="$({value} octomap)"{name.format("octomap_server")} pkg="octomap_server" {kind}="octomap_server_node">
    <remap from="cloud_in" to="/laserPointCloud"/>
    <param name="frame_id" value="odom"/>
  </node>
</launch>
"""


def _readme() -> str:
    checksums = {name: ros1_typestore().generate_msgdef(name, ros_version=1)[1] for name in OWN_TYPES}
    rows = "".join(f"| {_short(name)} | `{md5}` | `{schema(name).type_hash}` |\n" for name, md5 in checksums.items())
    return f"""# ROS packages of uwsim {version("uwsim")}

Written by `uwsim ros package`. Copy `ros1/` into the `src` folder of a catkin workspace, or `ros2/` into that of a
colcon workspace, and build it.

- `{MESSAGES}`: the messages that only uwsim has, such as `/telemetry` and `/map_changes`, and, for ROS 2, its
  services and actions.
- `{BRINGUP}`: `uwsim.launch` sets `use_sim_time` and starts RViz; `octomap:=true` starts octomap_server, too.

| message | ROS 1: md5 | ROS 2: RIHS01 |
|---|---|---|
{rows}"""
