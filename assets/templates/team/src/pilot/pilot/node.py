"""Drives the pilot as a ROS 2 node, with the simulator (`uwsim serve --ros2`) or with the vehicle itself."""

from functools import partial
from importlib import import_module

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from pilot.pilot import READS, WRITES, Pilot
from pilot.steering import PERIOD_S


def message_type(kind):
    """Return the class of messages of a type, such as std_msgs/msg/Empty."""
    return getattr(import_module(kind.rpartition("/")[0].replace("/", ".")), kind.rpartition("/")[2])


def fill(message, values):
    """Set a message's fields to plain values; return it."""
    for name, value in values.items():
        field = getattr(message, name)
        setattr(message, name, fill(field, value) if isinstance(value, dict) else type(field)(value))
    return message


class PilotNode(Node):
    """Subscribes to what the pilot reads, and publishes what it writes."""

    def __init__(self):
        super().__init__("pilot")
        self.pilot = Pilot(log=self.get_logger().info)
        for topic, kind in READS.items():
            receive = partial(self.pilot.receive, topic)
            self.create_subscription(message_type(kind), topic, receive, qos_profile_sensor_data)
        self.writers = {topic: self.create_publisher(message_type(kind), topic, 10) for topic, kind in WRITES.items()}
        self.create_timer(PERIOD_S, self.publish)

    def publish(self):
        """Publish the pilot's commands."""
        for topic, values in self.pilot.commands():
            if topic in self.writers:
                self.writers[topic].publish(fill(self.writers[topic].msg_type(), values))
            else:  # a note, for the referee of a course, or for a person
                self.get_logger().info(str(values))


def main():
    """Run the node until it is interrupted."""
    rclpy.init()
    rclpy.spin(PilotNode())
