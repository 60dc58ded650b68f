"""Starts the simulator's node and the pilot; with simulator:=false the pilot alone, for the vehicle itself."""

import tempfile

from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription

COURSE = "pool-course"


def generate_launch_description():
    """Return what is started. /odom is the vehicle's estimate, as on the vehicle."""
    simulator, course, seed = (LaunchConfiguration(name) for name in ("simulator", "course", "seed"))
    world = tempfile.mkdtemp() + "/world.yaml"
    serve = f" && exec uwsim serve {world} --ros2 --tf odom"
    start = ["uwsim course world ", course, f" {world} --seed ", seed, serve]
    return LaunchDescription([
        DeclareLaunchArgument("simulator", default_value="true"),
        DeclareLaunchArgument("course", default_value=COURSE),
        DeclareLaunchArgument("seed", default_value="0"),
        ExecuteProcess(cmd=["sh", "-c", start], condition=IfCondition(simulator)),
        Node(package="pilot", executable="node", parameters=[{"use_sim_time": simulator}]),
    ])  # fmt: skip
