"""Parameters: a mapping from names to the parameters of a simulator."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Protocol

from uwsim.base.named import UnknownNameError, did_you_mean
from uwsim.scenario import dump
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.scenario import Scenario
from uwsim.simulator.parameters import table
from uwsim.simulator.parameters.edits import KIND, edited
from uwsim.simulator.parameters.parameter import Parameter, plain
from uwsim.simulator.parameters.tree import Node, Place, find, nodes


class UnknownParameterError(UnknownNameError):
    """Raised for an unknown parameter name. The message suggests the most similar name."""


class Switch(Protocol):
    """A part that can be switched on and off, such as a lamp."""

    @property
    def on(self) -> bool:
        """Whether it is on."""

    def set_silently(self, on: bool) -> None:
        """Switch on or off without a journal entry."""


class Parameters(Mapping[str, Any]):
    """A simulator's parameters by name, such as `rov.drag.linear.surge`: the scenario's keys under a vehicle's name.

        sim.parameters["rov.drag.linear.surge"] = 40.0
        sim.parameters.update({"water.current_world_m_s": [0.3, 0, 0], "rov.thrusters.front_left.health": 0.5})

    Iteration yields the names of individual values. The name of a group, such as `rov.drag`, reads all its values as
    dicts and lists, and sets those that are passed. `water.surface`, `water.current`, `water.profile` and
    `optics.coefficients` are replaced as a whole.

    The changed scenario is validated as a whole: an invalid change raises ValueError with parameter, value, unit and
    rule, and changes nothing. A change applies from the next step on, as if it were in the scenario; motion, commands
    and samples in transit are preserved. Parameters may be read on any thread, but changed only on the stepping thread.
    """

    STATE: ClassVar[Any] = dict[str, Any]

    def __init__(
        self,
        scenario: Scenario,
        apply: Callable[[Scenario], None],
        note: Callable[..., None],
        switches: Mapping[str, Switch],
        overlay: Callable[[Scenario], Mapping[str, Any]] = lambda scenario: {},
    ) -> None:
        """Start with the values of a scenario.

        apply: applies the changed scenario, or raises. note: called with each change, as a command. switches: the
        switches whose state is a parameter, by parameter name. overlay: returns the values, by name, with which faults
        override those of a scenario; they are not in `changes`.
        """
        self._apply = apply
        self._note = note
        self._switches = dict(switches)
        self._overlay = overlay
        self.restart(scenario)

    def __repr__(self) -> str:
        changed = f"; changed: {', '.join(self._changes)}" if self._changes else ""
        return f"<Parameters of '{self._original.name}': sim.parameters.list('rov.drag') names some{changed}>"

    def restart(self, scenario: Scenario) -> None:
        """Start over with another scenario that has the same names, without applying it."""
        self._original = self._running = scenario
        self._changes: dict[str, Any] = {}
        self._tree: tuple[Scenario, dict[str, Node]] | None = None
        self._last_set: tuple[Scenario, dict[str, Node | None]] = scenario, {}

    def adopt(self, changes: Mapping[str, Any], running: Scenario) -> None:
        """Start with changes that have already been applied, which turned the scenario into `running`."""
        given: dict[str, Any] = {}
        for name, value in changes.items():
            self._spread(name, value, given)
        for name in given.keys() & self._switches.keys():
            self._switches[name].set_silently(given.pop(name))
        self._changes, self._running = given, running

    @property
    def scenario(self) -> Scenario:
        """The scenario with all changes applied. A Simulator created from it behaves like this one."""
        return self._running

    @property
    def changes(self) -> dict[str, Any]:
        """The values that have been set, by name, in plain types."""
        return dict(self._changes)

    def __getitem__(self, name: str) -> Any:
        """Return a value, or all values of a group. Raises UnknownParameterError (a KeyError and a ValueError)."""
        if name in self._switches:
            return self._switches[name].on
        return plain(self._node(name).value)

    def __setitem__(self, name: str, value: Any) -> None:
        """Set a value, or several values of a group. Raises ValueError, changing nothing."""
        self.update({name: value})

    def __iter__(self) -> Iterator[str]:
        return iter(_listed(self._all()))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        return self._find(name) is not None

    def list(self, prefix: str = "") -> list[str]:
        """Return the names of all effective values at or below a name.

        Raises UnknownParameterError, which suggests the most similar name, if there are none.
        """
        above = self._node(prefix) if prefix else None
        found = [*_listed(nodes(self._running, prefix) if prefix else self._all())]
        if above is not None and not found:
            raise UnknownParameterError(f"parameters[{prefix!r}]: {self._why_none(above)}")
        return found

    def _why_none(self, above: Node) -> str:
        """Return the reason why nothing at or below a name can be set."""
        if above.idle:
            return f"has no effect: {above.idle}"
        owner, _, part = above.name.rpartition(".")
        driven = "; it is driven by max_force_n and max_torque_nm" if part in ("thrusters", "fins") else ""
        return f"is empty: {owner or 'the scenario'} has none{driven}{did_you_mean(above.name, [*self])}"

    def describe(self, name: str) -> Parameter:
        """Return the type, unit, range, description, value and default of a parameter. Raises UnknownParameterError."""
        node = self._node(name)
        kind = node.type
        if kind is None:
            first = self.list(name)[0]
            raise UnknownParameterError(f"parameters[{name!r}]: has several values, such as {first}")
        return Parameter(
            name, node.key, kind.type, self[name], self._default(name), kind.unit, kind.low, kind.high, kind.choices,
            kind.optional, node.description,
        )  # fmt: skip

    def update(self, changes: Mapping[str, Any]) -> None:
        """Set several values at once. Raises ValueError, changing nothing."""
        if not isinstance(changes, Mapping):
            raise ScenarioError(f"parameters = {changes!r:.40}: must be values by name")
        wanted: dict[str, Any] = {}
        for name, value in changes.items():
            if not isinstance(name, str):
                self._node(name)
            self._spread(name, value, wanted)
        kept = self._changes
        for name in wanted:
            kept = {old: value for old, value in kept.items() if not _displaces(name, old)}
        switches = {name: value for name, value in wanted.items() if name in self._switches}
        self._switch_to({**kept, **wanted}, switches, new=wanted)
        self._note("set_parameters", changes=wanted)

    def reset(self, name: str | None = None) -> None:
        """Restore the scenario's values for one parameter, a group, or all. Raises ValueError, changing nothing."""
        if name is not None and find(self._original, name) is None:
            self._node(name)
        inside = {old for old in self._changes if name is None or old == name or old.startswith(name + ".")}
        above = [old for old in self._changes if name is not None and name.startswith(old + ".")]
        if above and not inside:
            raise ScenarioError(f"{name}: was set with {above[0]}: reset that instead")
        switches = {
            switch: self._default(switch)
            for switch in self._switches
            if name is None or switch == name or switch.startswith(name + ".")
        }
        self._switch_to({old: value for old, value in self._changes.items() if old not in inside}, switches)
        self._note("reset_parameters", name=name)

    def save(self) -> dict[str, Any]:
        """Return the saved state, `changes`, as JSON values."""
        return self.changes

    def restore(self, state: Mapping[str, Any]) -> None:
        """Set the values returned by `save`, and reset all others. Raises ValueError, changing nothing."""
        self._switch_to(dict(state), {})

    def scenario_with(self, values: Mapping[str, Any]) -> Scenario:
        """Return the scenario with these values, which are not set. Raises ValueError for invalid ones."""
        return self._with(values)

    def reapply(self) -> None:
        """Apply the current overlay again."""
        self._switch_to(self._changes, {})

    def _switch_to(self, changes: dict[str, Any], switches: Mapping[str, bool], new: Iterable[str] = ()) -> None:
        running = self._with(changes)
        last_set = running, {name: find(running, name) for name in new}
        for name, node in last_set[1].items():
            if node is not None and node.idle:
                raise ScenarioError(f"{name}: has no effect: {node.idle}")
        kept = {name: value for name, value in changes.items() if name not in self._switches}
        if len(kept) < len(changes):  # switches hold their own state, so they were only checked here
            running = self._with(kept)
        if running != self._running:
            self._apply(running)
            self._running, self._last_set = running, last_set
        self._changes = kept
        for name, on in switches.items():
            self._switches[name].set_silently(on)

    def _with(self, changes: Mapping[str, Any]) -> Scenario:
        """Return the scenario with these changes. Raises a ScenarioError phrased in parameter names."""
        places = {name: self._place(name) for name in changes}
        base = self._original
        try:
            if changes:
                base = edited(base, {places[name]: value for name, value in changes.items()})
            over = self._overlay(base)
            return edited(base, {self._place(name): value for name, value in over.items()}) if over else base
        except ScenarioError as error:
            raise ScenarioError.of([self._renamed(text) for text in error.mistakes]) from None

    def _spread(self, name: str, value: Any, into: dict[str, Any]) -> None:
        """Add a change to `into`; a change to a group is split into changes to its values."""
        node = self._find(name)
        if isinstance(value, Mapping) and node is not None and node.type is None and node.place not in table.WHOLE:
            for key, item in value.items():
                self._spread(f"{name}.{key}", item, into)
            return
        if node is not None and not node.place:
            raise ScenarioError(f"{name}: must be keys and values")
        into.pop(name, None)
        value = dump.plain(value) if isinstance(value, Model) else value
        is_one_of_a_list = isinstance(value, Mapping) and node is not None and node.place in table.LISTS
        into[name] = [plain(value)] if is_one_of_a_list else plain(value)

    def places(self, names: Iterable[str]) -> Sequence[Place]:
        """Return the key paths of these names in the scenario, for use with `edited`."""
        return [self._place(name) for name in names]

    def _place(self, name: str) -> Place:
        """Return the key path of a name. Below a part that is replaced as a whole, the name need not exist yet."""
        node = self._find(name) or find(self._original, name)
        if node is not None:
            return node.place
        for whole in table.WHOLE:
            above = ".".join(whole)
            if name.startswith(above + "."):
                return (*whole, *(table.position_or_key(part) for part in name.removeprefix(above + ".").split(".")))
        return self._node(name).place

    def _default(self, name: str) -> Any:
        node = self._find(name) if self._running is self._original else find(self._original, name)
        return None if node is None else plain(node.value)

    def _all(self) -> dict[str, Node]:
        """Return all leaves and groups by name."""
        made = self._tree
        if made is None or made[0] is not self._running:
            self._tree = made = self._running, nodes(self._running)
        return made[1]

    def _find(self, name: object) -> Node | None:
        """Return the node with this name, or None. Does not make the whole tree, which changes with every value."""
        if not isinstance(name, str):
            return None
        made, (set_in, last_set) = self._tree, self._last_set
        if made is not None and made[0] is self._running:
            return made[1].get(name)
        return last_set[name] if set_in is self._running and name in last_set else find(self._running, name)

    def _node(self, name: str) -> Node:
        node = self._find(name)
        if node is None:
            rule = table.why_fixed(str(name)) or "there is none" + did_you_mean(str(name), self._all())
            raise UnknownParameterError(f"parameters[{name!r}]: {rule}")
        return node

    def _renamed(self, text: str) -> str:
        """Replace the scenario key in an error message with the parameter name."""
        found = [node for node in self._all().values() if node.place and _begins(text, node.key)]
        if not found:
            return text
        nearest = max(found, key=lambda node: len(node.key))
        return nearest.name + text.removeprefix(nearest.key)


def _listed(tree: Mapping[str, Node]) -> Sequence[str]:
    """Return the names of individual values that currently have an effect."""
    return [name for name, node in tree.items() if node.type is not None and not node.idle]


def _begins(text: str, key: str) -> bool:
    return text.startswith(key) and text[len(key) : len(key) + 1] in (" ", ":", ".", "[", "")


def _displaces(name: str, old: str) -> bool:
    """Return whether a change supersedes an earlier one: of the same value, part of it, or another kind's keys."""
    above = name.removesuffix("." + KIND)
    return old == name or old.startswith(name + ".") or (above != name and old.startswith(above + "."))
