"""The names, requests and responses of the station's services, from which `wire_js` generates the page's functions."""

from __future__ import annotations

from dataclasses import dataclass

from uwsim.operator.station.wire.editor import Edit, EditForms, EditState
from uwsim.operator.station.wire.messages import (
    AllStop,
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
    MoveArm,
    Nothing,
    Order,
    SetView,
)
from uwsim.operator.station.wire.start import Catalog, Choice, ChoiceTaken
from uwsim.operator.station.wire.training import (
    ExerciseState,
    NotesRequest,
    NotesState,
    PlanRequest,
    PlanState,
)


@dataclass(frozen=True)
class Call:
    """A service `/station/NAME`.

    request, answer: the types of the request and of a successful response. A failure returns Refused. is_brief: whether
    calls are handled on the network thread. is_start_screen: whether the service belongs to the start screen, which a
    server with a fixed scenario does not offer.
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
    Call("describe", "describe the running simulator and the names of its topics and services", answer=Description),
    Call("join", "join under a name", Join, Joined),
    Call("take_control", "take control, if no other client has it"),
    Call("hand_over", "hand control over to another member", HandOver),
    Call("drive", "set efforts; for the pilot only", Drive, Driven),
    Call("move_arm", "move an arm while the call is repeated; for the pilot only", MoveArm, Driven),
    Call(
        "all_stop",
        "set all stop for a vehicle, or, as the pilot, release it",
        AllStop,
        Commanded,
    ),
    Call("command", "issue another command; for the pilot only", Order, Commanded),
    Call("exercise", "report how the exercise stands", answer=ExerciseState, is_brief=False),
    Call("plan", "save, fly, stop or report on a plan drawn on the chart", PlanRequest, PlanState, is_brief=False),
    Call("notes", "list inspection notes, add one, or set the comment", NotesRequest, NotesState, is_brief=False),
    Call("set_view", "change the rate, width and quality of a view", SetView),
    Call("catalog", "list the options of the start screen", answer=Catalog, is_brief=False, is_start_screen=True),
    Call("check", "report the errors of a choice", Choice, ChoiceTaken, is_brief=False, is_start_screen=True),
    Call("start", "start a simulator from a choice", Choice, ChoiceTaken, is_brief=False, is_start_screen=True),
    Call("edit_forms", "list a scenario's kinds of parts", answer=EditForms, is_brief=False, is_start_screen=True),
    Call(
        "edit", "open, change, check, save or apply a scenario", Edit, EditState, is_brief=False, is_start_screen=True
    ),
    Call(
        "control",
        "pause, step, restart, save, record and similar actions; for the pilot only",
        Control,
        Commanded,
        is_brief=False,
    ),
)
CALLS = {call.name: call for call in _CALLS}
