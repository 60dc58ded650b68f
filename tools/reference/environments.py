"""The reference of the learning environments: their tasks, observations and actions."""

from pathlib import Path

from tools.reference.markdown import code, plain, table

from uwsim.learning.task import Field, Task
from uwsim.learning.tasks import TASKS

HEAD = """# Learning environments

The environments registered by `import uwsim.learning`; [Learning](../guides/learning.md) shows how to use them.
Observations are float32 and clipped to their range, then divided by their usual size (not in version 0, nor with
`normalise=False`); body axes are x forward, y left, z up. Actions are efforts in [-1, 1], and `grip`
the speed at which both jaws close, in [-1, 1]. Values that are not measured by a sensor are exact.

"""


def environments_page() -> str:
    """Return the page, with a section for each environment."""
    return HEAD + "\n".join(_section(name, task) for name, task in TASKS.items())


def _section(name: str, task: type[Task]) -> str:
    text = f"## uwsim/{name}-v0\n\n{plain(task.__doc__ or '')}\n\n"
    text += f"One action every {task.period_s:g} s: {', '.join(task.action_names())}. "
    text += f"Truncated after {task.duration_s:g} s. "
    text += f"Scenario: `learning/{Path(str(task.scenario)).name}` in the assets."
    drawn = [f"`{key}` in ({low:g}, {high:g})" for key, (low, high) in task.randomize.items()]
    text += f" Drawn for each episode: {', '.join(drawn)}.\n\n" if drawn else "\n\n"
    rows, first = [], 0
    for field in task.fields():
        usual = ", ".join(f"{size:g}" for size in dict.fromkeys(field.sizes))
        rows.append(
            (_place(first, field), code(field.name), plain(field.unit), _range(field), usual, plain(field.about))
        )
        first += field.width
    return text + table(("numbers", "name", "unit", "range", "usual size", "what"), rows)


def _place(first: int, field: Field) -> str:
    return f"{first}" if field.width == 1 else f"{first} to {first + field.width - 1}"


def _range(field: Field) -> str:
    low = -field.limit if field.low is None else field.low
    return f"{low:g} ... {field.limit:g}"
