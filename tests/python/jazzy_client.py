"""A node of a real ROS 2 Jazzy that does what it is asked to: run by the Python of build/jazzy, which has no uwsim.

A line of its input is JSON: an operation's name and arguments. So is a line of its output: the value, or an error.
With the argument `pilot` it steers instead.
"""

import importlib
import json
import sys
import time
import traceback

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Parameter as ParameterMessage
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

PATIENCE_S = 180.0
STEERING_PERIOD_S = 0.05
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DEEP = QoSProfile(depth=10_000)
TYPES = (bool, int, float, str)


def python_type(name):
    """Return the class of a type such as sensor_msgs/msg/Imu."""
    package, group, short = name.split("/")
    return getattr(importlib.import_module(f"{package}.{group}"), short)


def nanoseconds(stamp):
    """Return a time in ns."""
    return 1_000_000_000 * stamp.sec + stamp.nanosec


class Client:
    """The operations."""

    def __init__(self):
        self.node = rclpy.create_node("client", parameter_overrides=[Parameter("use_sim_time", value=True)])
        self.parameters = AsyncParameterClient(self.node, "/uwsim")

    def until(self, condition):
        """Work until a condition is true, and return its value."""
        end_s = time.monotonic() + PATIENCE_S
        while not (value := condition()):
            assert time.monotonic() < end_s, "it did not happen"
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return value

    def answer(self, future):
        """Return a future's result."""
        return self.until(lambda: future.done() and [future.result()])[0]

    def listen(self, topic, kind, qos, **more):
        """Return a subscription and a list of what arrives."""
        heard = []
        return self.node.create_subscription(kind, topic, heard.append, qos, **more), heard

    def endpoints(self, topic):
        """Return uwsim's endpoints on a topic."""
        found = self.node.get_publishers_info_by_topic(topic) + self.node.get_subscriptions_info_by_topic(topic)
        return [one for one in found if one.node_name == "uwsim"]

    def graph(self, topics, services):
        """Return the nodes, uwsim's services, and type and hash of each topic, when all have been discovered."""
        self.until(lambda: all(map(self.endpoints, topics)))
        self.until(lambda: set(services) <= dict(self.node.get_service_names_and_types()).keys())
        found = {name: self.endpoints(name)[0] for name in topics}
        return {
            "nodes": self.node.get_node_names_and_namespaces(),
            "services": dict(self.node.get_service_names_and_types_by_node("uwsim", "/")),
            "topics": {name: [one.topic_type, str(one.topic_type_hash)] for name, one in found.items()},
        }

    def read(self, topics):
        """Return a message of each topic (type, latched), in hexadecimal, and the same after reading and writing it."""
        kinds = {name: python_type(kind) for name, (kind, _) in topics.items()}
        heard = {
            name: self.listen(name, kinds[name], LATCHED if latched else 10, raw=True)
            for name, (_, latched) in topics.items()
        }
        self.until(lambda: all(messages for _, messages in heard.values()))
        for subscription, _ in heard.values():
            self.node.destroy_subscription(subscription)
        first = {name: messages[0] for name, (_, messages) in heard.items()}
        again = {name: serialize_message(deserialize_message(data, kinds[name])) for name, data in first.items()}
        return {name: [first[name].hex(), again[name].hex()] for name in topics}

    def call(self, service, kind, times=1, **fields):
        """Call a service several times; return the responses (success, message), and each call's duration in ms."""
        found = python_type(kind)
        client = self.node.create_client(found, service)
        self.until(client.service_is_ready)
        responses, durations = [], []
        for _ in range(times):
            began = time.perf_counter()
            response = self.answer(client.call_async(found.Request(**fields)))
            durations.append(1e3 * (time.perf_counter() - began))
            responses.append([response.success, response.message])
        return {"responses": responses, "durations_ms": durations}

    def parameters_as_they_are(self):
        """List, describe, read and set all; return names, types, descriptions, values, reasons of refusals."""
        client = self.parameters
        self.until(client.services_are_ready)
        names = self.answer(client.list_parameters()).result.names
        described = self.answer(client.describe_parameters(names)).descriptors
        kinds = self.answer(client.get_parameter_types(names)).types
        values = self.answer(client.get_parameters(names)).values
        messages = [ParameterMessage(name=name, value=value) for name, value in zip(names, values, strict=True)]
        reasons = [one.reason for one in self.answer(client.set_parameters(messages)).results]
        assert not self.answer(client.set_parameters_atomically(messages)).result.reason
        texts = [one.description for one in described]
        plain = [Parameter.from_parameter_msg(message).value for message in messages]
        plain = [value if value is None or isinstance(value, TYPES) else list(value) for value in plain]
        return list(zip(names, map(int, kinds), texts, plain, reasons, strict=True))

    def set_parameters(self, values):
        """Set parameters; return the reasons of refusals."""
        self.until(self.parameters.services_are_ready)
        wanted = [Parameter(name, value=value) for name, value in values.items()]
        return [one.reason for one in self.answer(self.parameters.set_parameters(wanted)).results]

    def incompatible(self, topic, kind):
        """Subscribe to a volatile topic as to a latched one; return the policy that rclpy reports as incompatible."""
        events = []
        callbacks = SubscriptionEventCallbacks(incompatible_qos=events.append)
        subscription, heard = self.listen(topic, python_type(kind), LATCHED, event_callbacks=callbacks)
        (event,) = self.until(lambda: list(events))
        self.node.destroy_subscription(subscription)
        return [QoSPolicyKind(event.last_policy_kind).name, len(heard)]

    def follow(self):
        """Listen to time and odometry from now on."""
        self.clock = self.listen("/clock", Clock, DEEP)[1]
        self.odometry = self.listen("/odom", Odometry, DEEP)[1]

    def followed(self, more):
        """Return the times in ns of /clock and /odom, and of the node's clock, when so many more have arrived."""
        clocks, others = len(self.clock) + more, len(self.odometry) + more
        self.until(lambda: len(self.clock) >= clocks and len(self.odometry) >= others)
        found = [nanoseconds(one.clock) for one in self.clock], [nanoseconds(one.header.stamp) for one in self.odometry]
        return [*found, self.node.get_clock().now().nanoseconds]

    def ages_ms(self, topic, count):
        """Return the ages of messages that contain the time at which they were sent."""
        ages = []
        self.node.create_subscription(Float64, topic, lambda sent: ages.append(1e3 * (time.time() - sent.data)), 10)
        self.until(lambda: len(ages) >= count)
        return ages


def steer():
    """Publish a velocity until the process is killed, from a line of input on."""
    if not sys.stdin.readline():
        return
    publisher = rclpy.create_node("pilot").create_publisher(Twist, "/cmd_vel", 10)
    twist = Twist()
    twist.linear.x = 0.5
    while True:
        publisher.publish(twist)
        time.sleep(STEERING_PERIOD_S)


def main():
    """Answer each line."""
    client = Client()
    for line in sys.stdin:
        name, arguments = json.loads(line)
        try:
            found = {"value": getattr(client, name)(**arguments)}
        except Exception:
            found = {"error": traceback.format_exc()}
        sys.stdout.write(json.dumps(found) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    rclpy.init()
    steer() if "pilot" in sys.argv else main()
    rclpy.shutdown()
