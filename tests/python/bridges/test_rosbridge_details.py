"""Details of the rosbridge protocol: ids, compression, stamps, calls whose provider goes."""

import base64
import io
import json
import re
from pathlib import Path

from PIL import Image

from rosbridge_session import Client
from uwsim.bridges.rosbridge.encoding import to_png
from uwsim.bridges.rosbridge.session import Session

HERE = Path(__file__).parent
LINES = {  # of the table in docs/connections/rosbridge.md, by their first operations, and the test of each
    "advertise": "test_a_header_without_a_stamp_gets_the_present_time",
    "subscribe": "test_compressions",
    "unsubscribe": "test_only_the_subscription_with_the_id_ends_and_without_an_id_all_do",
    "call_service": "test_a_missing_service_and_one_whose_server_leaves_answer_false",
    "advertise_service": "test_an_open_call_fails_when_its_provider_unadvertises_the_service",
    "advertise_action": "test_a_goal_gets_feedback_and_a_result",
    "fragment": "test_operations_may_come_as_png_whole_or_in_fragments",
    "set_level": "test_the_level_is_set_by_either_name",
    "ack": "test_no_more_messages_are_on_their_way_than_the_credit",
}


def test_the_documented_table_names_every_operation_and_each_line_has_its_test():
    text = (HERE.parents[2] / "docs/connections/rosbridge.md").read_text().partition("| operation | support |")[2]
    rows = [re.findall(r"`(\w+)`", row.split("|")[1]) for row in text.partition("not offered")[0].splitlines()[2:-1]]
    assert {name for row in rows for name in row} == Session.operations.keys()
    assert [row[0] for row in rows] == list(LINES)
    tests = "".join(path.read_text() for path in HERE.glob("test_rosbridge_*.py"))
    assert all(f"def {name}(" in tests for name in LINES.values())


def test_only_the_subscription_with_the_id_ends_and_without_an_id_all_do(pair):
    one, two = pair
    one.send("advertise", topic="t", type="std_msgs/UInt8")
    for identity in ("a", "b"):
        two.send("subscribe", topic="t", id=identity)
    assert "no subscription with id 'c'" in two.send("unsubscribe", topic="t", id="c").complaint()
    one.send("publish", topic="t", msg={"data": 1})
    assert two.texts() == [1]
    two.send("unsubscribe", topic="t")
    one.send("publish", topic="t", msg={"data": 2})
    assert two.texts() == []


def test_operations_may_come_as_png_whole_or_in_fragments(pair):
    one, two = pair
    two.send("subscribe", topic="t", type="std_msgs/String")
    one.send("advertise", topic="t", type="std_msgs/String")

    def data(text):
        return json.loads(to_png(json.dumps({"op": "publish", "topic": "t", "msg": {"data": text}})))["data"]

    one.send("png", data=data("whole"))
    whole = data("in pieces")
    for number, part in enumerate((whole[:50], whole[50:])):
        one.send("png", id="x", data=part, num=number, total=2)
    assert two.texts() == ["whole", "in pieces"]
    assert "not a PNG" in one.send("png", data="bm90IGEgUE5H").complaint()
    bomb = io.BytesIO()
    Image.new("RGB", (2000, 2000)).save(bomb, "PNG")
    assert len(bomb.getvalue()) < 100_000
    assert "12000000 bytes of pixels" in one.send("png", data=base64.b64encode(bomb.getvalue()).decode()).complaint()


def test_a_header_without_a_stamp_gets_the_present_time(graph):
    graph.time_ns = lambda: 7_000_000_005
    publisher = Client(graph, "/p").send("advertise", topic="t", type="geometry_msgs/PoseStamped")
    reader = Client(graph, "/r").send("subscribe", topic="t")
    for header in ({"frame_id": "map"}, {"stamp": {"secs": 1, "nsecs": 2}}):
        publisher.send("publish", topic="t", msg={"header": header})
    stamps = [operation["msg"]["header"]["stamp"] for operation in reader.received()]
    assert stamps == [{"secs": 7, "nsecs": 5}, {"secs": 1, "nsecs": 2}]


def test_an_open_call_fails_when_its_provider_unadvertises_the_service(pair):
    one, two = pair
    one.send("advertise_service", service="/add", type="std_srvs/Trigger")
    two.send("call_service", service="/add", id="1")
    (request,) = one.received()
    one.send("unadvertise_service", service="add")
    (answer,) = two.received()
    assert answer["result"] is False and "ceased to offer it" in answer["values"]
    assert "no such call is waiting" in one.send("service_response", id=request["id"], service="/add").complaint()


def test_the_level_is_set_by_either_name(pair):
    one, _ = pair
    for op in ("set_level", "set_status_level"):
        one.send(op, level="none").send("nonsense")
        assert one.received() == []
        one.send(op, level="error").send("nonsense")
        assert "unknown" in one.complaint()


def whole(frames):
    """Reassemble a message from its fragments, as a client does."""
    parts = [json.loads(frame) for frame in frames]
    assert {part["op"] for part in parts} == {"fragment"} and len({part["id"] for part in parts}) == 1
    assert [part["num"] for part in parts] == list(range(len(parts))) and parts[0]["total"] == len(parts)
    return json.loads("".join(part["data"] for part in parts)), [len(part["data"]) for part in parts]


def test_messages_answers_and_results_come_in_fragments_of_the_size_asked_for(pair):
    one, two = pair
    one.send("subscribe", topic="t", type="std_msgs/String", fragment_size=100)
    one.send("subscribe", topic="t", id="b", fragment_size=40)
    two.send("advertise", topic="t", type="std_msgs/String").send("publish", topic="t", msg={"data": 'é"' * 60})
    message, sizes = whole(one.frames())
    assert message["msg"]["data"] == 'é"' * 60 and set(sizes[:-1]) == {40}, "the smallest of all ids"
    two.send("advertise_service", service="s", type="std_srvs/Trigger")
    one.send("call_service", service="s", id="1", fragment_size=30)
    two.send("service_response", id=two.received()[0]["id"], service="s", values={"message": "m" * 99}, result=True)
    answer, sizes = whole(one.frames())
    assert answer["values"] == {"message": "m" * 99} and set(sizes[:-1]) == {30}
    assert "fragment_size = 0" in one.send("subscribe", topic="t", fragment_size=0).complaint()
    assert one.session.outbox.kept.bytes == two.session.outbox.kept.bytes == 0, "nothing is kept"


def test_a_message_has_a_thousand_fragments_at_most(pair):
    one, two = pair
    one.send("subscribe", topic="t", type="std_msgs/String", fragment_size=1)
    two.send("advertise", topic="t", type="std_msgs/String").send("publish", topic="t", msg={"data": "x" * 5000})
    frames = one.frames()
    assert len(frames) <= 1000 and whole(frames)[0]["msg"]["data"] == "x" * 5000


def test_header_seq_counts_a_topic_s_messages_in_ros_1(graph):
    readers = [Client(graph, f"/r{k}").send("subscribe", topic="t", type="geometry_msgs/PoseStamped") for k in (1, 2)]
    binary = Client(graph, "/b").send("subscribe", topic="t", compression="cbor-raw")
    newer = Client(graph, "/n", ros=2).send("subscribe", topic="t", type="geometry_msgs/PoseStamped")
    publisher = Client(graph, "/p").send("advertise", topic="t", type="geometry_msgs/PoseStamped")
    for _ in range(3):
        publisher.send("publish", topic="t", msg={"header": {"seq": 77}})
    for reader in readers:
        assert [operation["msg"]["header"]["seq"] for operation in reader.received()] == [0, 1, 2]
    assert [operation["msg"]["bytes"][0] for operation in binary.received()] == [0, 1, 2]
    assert all("seq" not in operation["msg"]["header"] for operation in newer.received())


def goal_of(provider):
    (goal,) = provider.received()
    assert (goal["op"], goal["action"], goal["action_type"]) == ("send_action_goal", "/dock", "x_msgs/Dock")
    return goal


def test_a_goal_gets_feedback_and_a_result(pair):
    one, two = pair
    one.send("advertise_action", action="/dock", type="x_msgs/Dock")
    two.send("send_action_goal", action="dock", action_type="x_msgs/Dock", id="g", args={"port": 2}, feedback=True)
    goal = goal_of(one)
    assert goal["args"] == {"port": 2}
    one.send("action_feedback", id=goal["id"], action="/dock", values={"distance": 3.5})
    one.send("action_result", id=goal["id"], action="/dock", values={"docked": True}, status=4, result=True)
    assert two.received() == [
        {"op": "action_feedback", "action": "dock", "id": "g", "values": {"distance": 3.5}},
        {"op": "action_result", "action": "dock", "id": "g", "values": {"docked": True}, "status": 4, "result": True},
    ]
    assert "no such goal is in progress" in one.send("action_result", id=goal["id"], action="/dock").complaint()
    two.send("send_action_goal", action="/dock", id="quiet")
    one.send("action_feedback", id=goal_of(one)["id"], action="/dock", values={})
    assert two.received() == [], "feedback comes only if it is asked for"


def test_a_cancelled_goal_ends_with_the_result_of_its_provider(pair):
    one, two = pair
    one.send("advertise_action", action="/dock", type="x_msgs/Dock")
    two.send("send_action_goal", action="/dock", id="g")
    goal = goal_of(one)
    two.send("cancel_action_goal", action="/dock", id="g")
    assert one.received() == [{"op": "cancel_action_goal", "id": goal["id"], "action": "/dock"}]
    one.send("action_result", id=goal["id"], action="/dock", values={}, status=5, result=False)
    (result,) = two.received()
    assert (result["status"], result["result"]) == (5, False)
    assert "no goal in progress with id 'g'" in two.send("cancel_action_goal", action="/dock", id="g").complaint()


def test_a_goal_is_aborted_with_a_reason_when_no_client_can_pursue_it(graph, pair):
    one, two = pair

    def result(reason):
        (found,) = two.received()
        assert (found["op"], found["id"], found["status"], found["result"]) == ("action_result", "g", 6, False)
        assert reason in found["values"]

    two.send("send_action_goal", action="/dock", id="g")
    result("no client offers it")
    one.send("advertise_action", action="/dock", type="x_msgs/Dock")
    two.send("send_action_goal", action="/dock", action_type="x_msgs/Other", id="g")
    result("is x_msgs/Dock, not 'x_msgs/Other'")
    assert "offers it already" in two.send("advertise_action", action="dock", type="x_msgs/Dock").complaint()
    two.send("send_action_goal", action="/dock", id="g")
    one.send("unadvertise_action", action="/dock")
    result("has ceased to offer it")
    one.send("advertise_action", action="/dock", type="x_msgs/Dock")
    two.send("send_action_goal", action="/dock", id="g")
    assert "is still in progress" in two.send("send_action_goal", action="/dock", id="g").complaint()
    one.session.close()
    result("has left")
    assert graph.actions == {} and two.session.outbox.kept.bytes == 0


def test_goals_of_a_client_that_leaves_are_cancelled(pair):
    one, two = pair
    one.send("advertise_action", action="/dock", type="x_msgs/Dock")
    two.send("send_action_goal", action="/dock", id="g")
    goal = goal_of(one)
    two.session.close()
    assert one.received() == [{"op": "cancel_action_goal", "id": goal["id"], "action": "/dock"}]
    one.send("action_result", id=goal["id"], action="/dock", values={}, status=5, result=False)
    assert one.received() == [] and one.session.outbox.kept.bytes == 0
