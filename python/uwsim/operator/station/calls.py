"""The services of the station: names, requests and responses. `wire_js` generates the page's functions from them."""

from __future__ import annotations

from dataclasses import dataclass

from uwsim.operator.station.wire import (
    AllStop,
    Catalog,
    Choice,
    ChoiceTaken,
    Commanded,
    Control,
    Description,
    Done,
    Drive,
    Driven,
    HandOver,
    Join,
    Joined,
    Message,
    Nothing,
    Order,
    SetView,
)


@dataclass(frozen=True)
class Call:
    """A service `/station/NAME`.

    request, answer: types of the request and of a successful response; a failure returns Refused. is_brief: whether it
    is handled on the network thread. is_start_screen: whether it belongs to the start screen, so that a server with a
    fixed scenario does not offer it.
    """

    name: str
    description: str
    request: type[Message] = Nothing
    answer: type[Message] = Done
    is_brief: bool = True
    is_start_screen: bool = False

    @property
    def ros_type(self) -> str:
        """The ROS name of the service type."""
        return "uwsim_msgs/srv/Station" + "".join(part.capitalize() for part in self.name.split("_"))


_CALLS = (
    Call("describe", "what runs, and under which names it is seen", answer=Description),
    Call("join", "take part under a name", Join, Joined),
    Call("take_control", "have the controls, if nobody has them"),
    Call("hand_over", "pass the controls on", HandOver),
    Call("drive", "set efforts, by the pilot", Drive, Driven),
    Call("all_stop", "stop a vehicle against all commands, by anybody; release it, by the pilot", AllStop, Commanded),
    Call("command", "give another command, by the pilot", Order, Commanded),
    Call("set_view", "change the rate, width and quality of a view", SetView),
    Call("catalog", "what can be chosen on the start screen", answer=Catalog, is_brief=False, is_start_screen=True),
    Call("check", "say what is wrong with a choice", Choice, ChoiceTaken, is_brief=False, is_start_screen=True),
    Call("start", "run a simulator of a choice", Choice, ChoiceTaken, is_brief=False, is_start_screen=True),
    Call(
        "control", "pause, step, restart, save, record and the like; by the pilot", Control, Commanded, is_brief=False
    ),
)
CALLS = {call.name: call for call in _CALLS}
