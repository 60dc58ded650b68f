"""The files of the packages uwsim_msgs, uwsim_description and uwsim_bringup, for catkin (ROS 1) and ament (ROS 2)."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path

from uwsim.bridges.ros_packages.description import described
from uwsim.bridges.ros_packages.launch import DEFAULTS, SERVE, VIEWERS, display, simulate
from uwsim.bridges.ros_packages.rviz import rviz_configuration
from uwsim.channels.ros.action_types import ACTION_TYPES, load_action_types
from uwsim.channels.ros.cdr import schema
from uwsim.channels.ros.message_types import Ros, fields, ros1_typestore
from uwsim.channels.ros.own_types import OWN_TYPES
from uwsim.channels.ros.service_types import SERVICE_TYPES

MESSAGES, DESCRIPTION, BRINGUP = "uwsim_msgs", "uwsim_description", "uwsim_bringup"
OWN_SERVICES = [name for name in SERVICE_TYPES if name.startswith(f"{MESSAGES}/")]
OWN_ACTIONS = [name for name in ACTION_TYPES if name.startswith(f"{MESSAGES}/")]


def ros_packages(scenario: str = "lake") -> dict[str, str]:
    """Return the text of each file, keyed by path: ros1/ and ros2/ with the three packages, and a README.

    scenario: that whose vehicles are described, and which the launch file starts: a name or a path. Raises
    ScenarioError.
    """
    if Path(scenario).is_file():
        scenario = str(Path(scenario).resolve())
    files = {"README.md": _readme()}
    vehicles = described(scenario, DESCRIPTION)
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
        files |= {f"ros{ros}/{DESCRIPTION}/{name}": text for name, text in vehicles.items()}
        about = f"The vehicles of uwsim's scenario {Path(scenario).stem} as URDF."
        files[f"ros{ros}/{DESCRIPTION}/package.xml"] = _manifest(ros, DESCRIPTION, about, "")
        files[f"ros{ros}/{DESCRIPTION}/CMakeLists.txt"] = _build_of_files(ros, DESCRIPTION, "meshes urdf")
        files |= {f"{bringup}/{name}": text for name, text in _bringup(ros, scenario).items()}
    return files


def _bringup(ros: Ros, scenario: str) -> dict[str, str]:
    suffix = "" if ros == 1 else ".xml"
    viewers = "".join(f"  <exec_depend>{name}</exec_depend>\n" for name in VIEWERS[ros])
    files = {
        "package.xml": _manifest(ros, BRINGUP, "Starts uwsim, and displays its topics, and maps from them.", viewers),
        "CMakeLists.txt": _build_of_files(ros, BRINGUP, "config launch rviz"),
        f"launch/uwsim.launch{suffix}": display(ros, BRINGUP),
        f"launch/simulate.launch{suffix}": simulate(ros, BRINGUP, scenario),
        "config/parameters.yaml": DEFAULTS,
        "rviz/uwsim.rviz": rviz_configuration(ros),
    }
    if ros == 1:
        files["scripts/serve"] = SERVE
        files["CMakeLists.txt"] += "install(PROGRAMS scripts/serve DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})\n"
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


def _build_of_files(ros: Ros, name: str, folders: str) -> str:
    """Return the build of a package that only installs folders."""
    if ros == 1:
        return f"""cmake_minimum_required(VERSION 3.0.2)
project({name})
find_package(catkin REQUIRED)
catkin_package()
install(DIRECTORY {folders} DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})
"""
    return f"""cmake_minimum_required(VERSION 3.8)
project({name})
find_package(ament_cmake REQUIRED)
install(DIRECTORY {folders} DESTINATION share/${{PROJECT_NAME}})
ament_package()
"""


def _readme() -> str:
    checksums = {name: ros1_typestore().generate_msgdef(name, ros_version=1)[1] for name in OWN_TYPES}
    rows = "".join(f"| {_short(name)} | `{md5}` | `{schema(name).type_hash}` |\n" for name, md5 in checksums.items())
    return f"""# ROS packages of uwsim {version("uwsim")}

Written by `uwsim ros package`. Copy `ros1/` into the `src` folder of a catkin workspace, or `ros2/` into that of a
colcon workspace, and build it.

- `{MESSAGES}`: the messages that only uwsim has, such as `/telemetry` and `/map_changes`, and, for ROS 2, its
  services and actions.
- `{DESCRIPTION}`: the vehicles as URDF, with meshes. A running uwsim publishes the same on `/robot_description`.
- `{BRINGUP}`: `simulate.launch` starts uwsim, which must be on the PATH, sets the parameters in
  `config/parameters.yaml`, and includes `uwsim.launch`, which sets `use_sim_time` and starts RViz; `octomap:=true`
  starts octomap_server, too. `uwsim.launch` alone displays a simulator that is already running.

| message | ROS 1: md5 | ROS 2: RIHS01 |
|---|---|---|
{rows}"""
