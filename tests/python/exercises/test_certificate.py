"""A certificate has what the log book has of a person; no value of a signed one can be changed."""

import json
from datetime import datetime

import pytest

from command_line import uwsim
from signing_keys import made_keys
from test_sheet import exercise, still
from uwsim.exercises.certificate import certificate_of, check_certificate
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.logbook import logbook_path, read_book


@pytest.fixture
def keys(tmp_path, monkeypatch):
    """Two attempts of Ada in the log book, and two pairs of keys."""
    monkeypatch.setenv("UWSIM_LOGBOOK", str(tmp_path / "logbook.jsonl"))
    for title in ("Hover", "Hold <it>"):
        fly_exercise(exercise(title), still, person="Ada")
    for name in ("centre", "other"):
        made_keys(tmp_path, name)
    return tmp_path


def test_it_lists_packaged_and_own_exercises_by_task_and_a_changed_line_counts_for_nobody(keys):
    path = logbook_path()
    made = certificate_of(read_book(path), "Ada")
    by_task = {each["task"]: {one["title"]: one for one in each["exercises"]} for each in made["tasks"]}
    assert by_task["station keeping"]["Hover"]["attempts"] == 1 and by_task["station keeping"]["Hover"]["has_passed"]
    assert by_task["inspection"]["Net inspection"]["best"] is None
    assert by_task["other exercises"]["Hold <it>"]["attempts"] == 1 and made["totals"]["attempts"] == 2
    path.write_text(path.read_text().replace('"title":"Hover"', '"title":"Docking"'))
    again = certificate_of(read_book(path), "Ada")
    assert again["totals"]["attempts"] == 1 and again["logbook"]["not_valid"] == 1
    with pytest.raises(ValueError, match="has no valid line"):
        certificate_of(read_book(path), "Bob")


def test_a_signed_one_is_checked_by_the_centre_s_key_and_no_change_passes(keys):
    options = ("exercise", "logbook", "--person", "Ada", "--certificate", keys / "ada", "--sign", keys / "centre.pem")
    assert uwsim(*options).returncode == 0
    assert "Hold &lt;it&gt;" in (keys / "ada/certificate.html").read_text()
    path = keys / "ada/certificate.json"
    check = ("exercise", "logbook", "--check", path, "--signed-by")
    assert "signed by" in uwsim(*check, keys / "centre.pub").stdout
    with pytest.raises(ValueError, match="by another key"):
        check_certificate(path, keys / "other.pub")
    found = json.loads(path.read_text())
    for key in found.keys() - {"signature"}:
        path.write_text(json.dumps({**found, key: "forged"}))
        with pytest.raises(ValueError, match="has been changed"):
            check_certificate(path, keys / "centre.pub")
    forged = certificate_of(read_book(logbook_path()), "Ada", datetime(2020, 1, 1))  # with a digest of its own
    path.write_text(json.dumps({**forged, "signature": found["signature"]}))
    with pytest.raises(ValueError, match="signature is not that"):
        check_certificate(path, None)
    path.write_text(json.dumps(forged))
    assert check_certificate(path, None).endswith("not signed")
    with pytest.raises(ValueError, match="has no signature"):
        check_certificate(path, keys / "centre.pub")
