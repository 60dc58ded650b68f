"""Starts the simulator's node and the pilot; with simulator:=false the pilot alone, for the vehicle itself."""

from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription


def generate_launch_description():
    """Return what is started. /odom is the vehicle's estimate, as on the vehicle."""
    simulator = LaunchConfiguration("simulator")
    return LaunchDescription([
        DeclareLaunchArgument("simulator", default_value="true"),
        ExecuteProcess(cmd=["uwsim", "serve", "course", "--ros2", "--tf", "odom"], condition=IfCondition(simulator)),
        Node(package="pilot", executable="node", parameters=[{"use_sim_time": simulator}]),
    ])  # fmt: skip
