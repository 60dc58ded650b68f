"""Starts the pilot, for the vehicle itself. This course is flown in the simulator by `uwsim course score`."""

from launch_ros.actions import Node

from launch import LaunchDescription


def generate_launch_description():
    """Return what is started. /odom is the vehicle's estimate."""
    return LaunchDescription([Node(package="pilot", executable="node")])
