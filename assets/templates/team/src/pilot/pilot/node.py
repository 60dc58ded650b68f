"""Drives the pilot as a ROS 2 node, with the simulator (`uwsim serve --ros2`) or with the vehicle itself."""

from functools import partial

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosidl_runtime_py import set_message_fields
from rosidl_runtime_py.utilities import get_message

from pilot.pilot import PERIOD_S, READS, WRITES, Pilot


class PilotNode(Node):
    """Subscribes to what the pilot reads, and publishes what it writes."""

    def __init__(self):
        super().__init__("pilot")
        self.pilot = Pilot(log=self.get_logger().info)
        for topic, kind in READS.items():
            receive = partial(self.pilot.receive, topic)
            self.create_subscription(get_message(kind), topic, receive, qos_profile_sensor_data)
        self.writers = {topic: self.create_publisher(get_message(kind), topic, 10) for topic, kind in WRITES.items()}
        self.create_timer(PERIOD_S, self.publish)

    def publish(self):
        """Publish the pilot's commands."""
        for topic, values in self.pilot.commands():
            if topic == "note":  # for the referee of a course, or for a person
                self.get_logger().info(str(values))
                continue
            message = self.writers[topic].msg_type()
            set_message_fields(message, values)
            self.writers[topic].publish(message)


def main():
    """Run the node until it is interrupted."""
    rclpy.init()
    rclpy.spin(PilotNode())
