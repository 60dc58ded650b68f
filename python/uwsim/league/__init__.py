"""The league: courses that teams' programs fly, scored over many seeds without a server.

    result = uwsim.league.score_team("team", seeds=range(1, 21), out="results")

A team's folder has a `team.yaml`, as `uwsim course new` writes it. Its program is a process of its own, which sees the
vehicle's topics and nothing else, and for which simulated time waits.
"""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.league.score import score_team
    from uwsim.league.team import Team, load_team

__all__ = ["Team", "load_team", "score_team"]

__getattr__ = lazy(__name__, {"Team": "team", "load_team": "team", "score_team": "score"})
