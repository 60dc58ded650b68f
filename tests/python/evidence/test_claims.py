"""The numbers that other simulators print, asked of uwsim: verdicts hold, and what cannot be asked is refused."""

import json
import math
from pathlib import Path

import pytest

from command_line import error_line, uwsim
from uwsim.evidence.reproduce.claim_asks import asked
from uwsim.evidence.reproduce.claims import MARKS, Answer, claims_table, load_claims
from uwsim.scenario import ScenarioError
from uwsim.scenario.read.assets import assets_folder

CLAIMS = load_claims()
QUICK = [claim for claim in CLAIMS.claims if not claim.timed]
PAGE = Path(__file__).parents[3] / "docs/inside/reality.md"


@pytest.fixture(scope="module")
def answers() -> list[Answer]:
    return [Answer(claim, asked(**claim.ask)) for claim in QUICK]


def test_every_verdict_is_the_one_that_was_found(answers: list[Answer]) -> None:
    assert [answer.claim.name for answer in answers if answer.has_changed] == []
    assert {answer.verdict for answer in answers} == {"agrees", "differs"}  # a miss stays
    assert len({claim.simulator for claim in CLAIMS.claims}) == 7


def test_the_page_has_the_rows_that_the_command_makes(answers: list[Answer]) -> None:
    shown = PAGE.read_text().partition(MARKS[0])[2].partition(MARKS[1])[0]
    for row in claims_table(CLAIMS, answers).splitlines()[4:]:
        assert row in shown
    assert shown.count("\n- ") == len(CLAIMS.claims)


def test_a_speed_is_that_at_which_the_drag_is_the_force() -> None:
    found = asked("terminal_speed", force_n=90.0, linear_n_s_m=30.0, quadratic_n_s2_m2=60.0)
    assert 30.0 * found + 60.0 * found**2 == pytest.approx(90.0, rel=1e-3)


def test_bottom_lock_ends_where_the_slanted_beams_do() -> None:
    found = asked("dvl_altitude", slant_deg=45.0, range_max_m=50.0)
    assert found == pytest.approx(50.0 * math.cos(math.radians(45.0)), abs=0.1)


def test_beams_beyond_their_range_are_not_counted() -> None:
    """A wall at 7 m meets those of 121 beams by 1 deg to 10 m that are within acos(0.7) = 45.6 deg of ahead."""
    assert asked("beams_on_wall", beams=121, field_of_view_deg=120.0, range_max_m=10.0, wall_m=7.0) == 91


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("kind: pressure, depth_m: 10", "kind: guess, depth_m: 10", "must be one of terminal_speed"),
        ("kind: pressure, depth_m: 10", "kind: pressure, height_m: 10", "must have depth_m, density_kg_m3"),
        ("verdict: differs\n    remark: Stonefish", "verdict: maybe\n    remark: Stonefish", "verdict"),
    ],
)
def test_a_claim_that_cannot_be_asked_is_refused(old: str, new: str, words: str, tmp_path: Path) -> None:
    text = (assets_folder() / "claims/simulators.yaml").read_text()
    assert text.count(old) == 1
    (tmp_path / "mine.yaml").write_text(text.replace(old, new))
    with pytest.raises(ScenarioError, match=words):
        load_claims(tmp_path / "mine.yaml")


def test_the_command_writes_the_table_and_its_values(tmp_path: Path) -> None:
    done = uwsim("reproduce", "claims", "--quick", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    values = json.loads((tmp_path / "out/claims.json").read_text())
    assert [value["name"] for value in values] == [claim.name for claim in QUICK]
    assert f"{sum(value['verdict_now'] == 'agrees' for value in values)} of {len(QUICK)} agree" in done.stdout
    assert "| **differs**" in (tmp_path / "out/claims.md").read_text()
    (tmp_path / "page.md").write_text("no marks\n")
    assert "--page" in error_line(uwsim("reproduce", "claims", "--page", tmp_path / "page.md", "--out", tmp_path / "b"))
    assert "is not for claims" in error_line(uwsim("reproduce", "claims", "--scene", "LawnTest"))
    assert "is for claims" in error_line(uwsim("reproduce", "paper", "--quick"))
