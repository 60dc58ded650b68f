"""roslibpy against our rosbridge, through its public API."""

import queue
import time

import pytest
import roslibpy
import roslibpy.tf

from uwsim.bridges import RosbridgeServer
from waiting import until

PATIENCE_S = 180.0


def take(heard):
    return heard.get(timeout=PATIENCE_S)


@pytest.fixture(scope="module")
def server():
    with RosbridgeServer(None) as server:
        yield server


@pytest.fixture
def connect(server):
    """Return a function that connects a client. Twisted's reactor cannot be restarted, so clients only close."""
    clients = []

    def new(port=None):
        client = roslibpy.Ros("127.0.0.1", port or server.port)
        client.run(PATIENCE_S)
        clients.append(client)
        return client

    yield new
    for client in clients:
        client.close()


def test_publish_and_subscribe_with_and_without_a_slash(connect):
    one, two = connect(), connect()
    heard = queue.Queue()
    roslibpy.Topic(two, "/chatter", "std_msgs/String").subscribe(heard.put)
    until(one.get_topics)
    roslibpy.Topic(one, "chatter", "std_msgs/String").publish({"data": "hello"})
    assert take(heard) == {"data": "hello"}


def test_headers_with_nulls_and_ros_times(connect):
    client = connect()
    heard = queue.Queue()
    topic = roslibpy.Topic(client, "/stamped", "geometry_msgs/PoseStamped")
    topic.subscribe(heard.put)
    topic.publish({"header": roslibpy.Header(frame_id="odom")})  # with seq and stamp null
    assert take(heard)["header"] == {"seq": 0, "stamp": {"secs": 0, "nsecs": 0}, "frame_id": "odom"}
    topic.publish({"header": roslibpy.Header(seq=1, stamp=roslibpy.Time(12, 34), frame_id="odom")})
    assert take(heard)["header"]["stamp"] == {"secs": 12, "nsecs": 34}


def test_throttle(connect):
    client = connect()
    heard = queue.Queue()
    roslibpy.Topic(client, "/fast", "std_msgs/UInt8", throttle_rate=100_000).subscribe(heard.put)
    publisher, end = roslibpy.Topic(client, "/fast", "std_msgs/UInt8"), queue.Queue()
    roslibpy.Topic(client, "/end", "std_msgs/Empty").subscribe(end.put)
    for k in range(50):
        publisher.publish({"data": k})
    roslibpy.Topic(client, "/end", "std_msgs/Empty").publish({})
    take(end)
    assert heard.qsize() == 1


def test_unsubscribe_and_unadvertise(connect):
    client = connect()
    heard, end = queue.Queue(), queue.Queue()
    topic = roslibpy.Topic(client, "/gone", "std_msgs/UInt8")
    topic.subscribe(heard.put)
    topic.unsubscribe()
    topic.publish({"data": 1})
    assert "/gone" in client.get_topics()
    topic.unadvertise()
    roslibpy.Topic(client, "/end2", "std_msgs/Empty").subscribe(end.put)
    roslibpy.Topic(client, "/end2", "std_msgs/Empty").publish({})
    take(end)
    assert "/gone" not in client.get_topics() and heard.empty()


def test_services_both_ways(connect):
    one, two = connect(), connect()

    def add(request, response):
        response["sum"] = request["a"] + request["b"]
        return True

    service = roslibpy.Service(one, "/add_two_ints", "rospy_tutorials/AddTwoInts")
    service.advertise(add)
    until(lambda: "/add_two_ints" in two.get_services())
    client = roslibpy.Service(two, "/add_two_ints", "rospy_tutorials/AddTwoInts")
    assert client.call(roslibpy.ServiceRequest({"a": 2, "b": 3}), timeout=PATIENCE_S) == {"sum": 5}
    service.unadvertise()
    until(lambda: "/add_two_ints" not in two.get_services())
    with pytest.raises(roslibpy.core.ServiceException, match="nobody offers it"):
        client.call(roslibpy.ServiceRequest({}), timeout=PATIENCE_S)


def test_parameters(connect):
    client = connect()
    gain = roslibpy.Param(client, "gain")
    assert gain.get(timeout=PATIENCE_S) is None
    gain.set({"p": [1, 2.5]}, timeout=PATIENCE_S)
    assert gain.get(timeout=PATIENCE_S) == {"p": [1, 2.5]}
    assert client.get_params() == ["/gain"]
    gain.delete(timeout=PATIENCE_S)
    assert gain.get(timeout=PATIENCE_S) is None


def test_questions_about_the_graph(connect):
    client = connect()
    roslibpy.Topic(client, "/asked", "sensor_msgs/LaserScan").advertise()
    assert client.get_topic_type("/asked") == "sensor_msgs/LaserScan"
    assert client.get_topics_for_type("sensor_msgs/LaserScan") == ["/asked"]
    assert "/rosapi" in client.get_nodes()
    assert "/rosapi/topics" in client.get_node_details("/rosapi")["services"]
    assert client.get_service_type("/rosapi/topics") == "rosapi/Topics"
    assert client.get_services_for_type("rosapi/Topics") == ["/rosapi/topics"]
    assert client.get_message_details("geometry_msgs/Twist")["typedefs"][0]["fieldnames"] == ["linear", "angular"]
    assert client.get_service_request_details("std_srvs/SetBool")["typedefs"][0]["fieldnames"] == ["data"]
    assert client.get_service_response_details("std_srvs/SetBool")["typedefs"][0]["fieldnames"] == [
        "success",
        "message",
    ]
    assert client.get_action_servers(lambda result: None, lambda error: None) is None
    assert client.get_time().is_zero()


def stamped(parent, child, x, quaternion):
    return {
        "header": {"frame_id": parent},
        "child_frame_id": child,
        "transform": {"translation": {"x": x}, "rotation": dict(zip("xyzw", quaternion, strict=True))},
    }


def test_tf_client(connect):
    client = connect()
    heard = queue.Queue()
    roslibpy.tf.TFClient(client, fixed_frame="world", rate=50.0, update_delay=1).subscribe("sonar", heard.put)
    until(lambda: client.get_topics_for_type("tf2_web_republisher/TFArray"))
    turned = (0.0, 0.0, 0.5**0.5, 0.5**0.5)  # a quarter turn to the left
    tf = roslibpy.Topic(client, "/tf", "tf2_msgs/TFMessage")
    tf.publish({"transforms": [stamped("world", "rov", 3.0, turned), stamped("rov", "sonar", 2.0, (0, 0, 0, 1))]})
    found = take(heard)
    assert found["translation"] == pytest.approx({"x": 3.0, "y": 2.0, "z": 0.0})
    assert found["rotation"] == pytest.approx(dict(zip("xyzw", turned, strict=True)))


def test_a_client_comes_back_after_the_server_was_away(connect):
    server = RosbridgeServer(None).start()
    client, heard = connect(server.port), queue.Queue()
    client.factory.initialDelay = client.factory.delay = 0.2
    roslibpy.Topic(client, "/after", "std_msgs/String").subscribe(heard.put)
    server.stop()
    deadline = time.monotonic() + PATIENCE_S
    with RosbridgeServer(None, port=server.port):
        while heard.empty() and time.monotonic() < deadline:
            if client.is_connected:
                roslibpy.Topic(client, "/after", "std_msgs/String").publish({"data": "again"})
            time.sleep(0.1)
        assert take(heard) == {"data": "again"}
        client.close()
