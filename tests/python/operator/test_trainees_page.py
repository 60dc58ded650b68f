"""One instructor and the trainees of two stations, in a real browser."""

from browser import exercise_desk, judge, shows, until, when
from uwsim.exercises import load_exercise

TOKEN = "a-secret-of-18-byte"


def test_each_row_shows_and_steers_its_own_station(browser, tmp_path):
    hover, other = load_exercise("hover"), load_exercise("depth-gauge")
    with (
        exercise_desk(browser, tmp_path / "one", hover, instructor_token=TOKEN) as one,
        exercise_desk(browser, tmp_path / "two", other, instructor_token=TOKEN) as two,
    ):
        page = one.fly(viewport={"width": 640, "height": 480})
        address = f"ws://{two.url.split('/')[2]}"
        console = one.open(f"/trainees.html?rosbridge={address}#{TOKEN}", viewport={"width": 1280, "height": 600})
        rows = [f".trainees tbody tr:nth-child({k})" for k in (1, 2)]
        for row, exercise in zip(rows, (hover, other), strict=True):
            shows(console, row, exercise.title)
            shows(console, row, f"of {exercise.points:.0f} points")
            shows(console, row, "not begun")
        judge(console, "trainees")

        page.click(".exercise-begin")
        shows(console, rows[0], "flying")
        console.click(f"{rows[0]} >> text=Pause")
        when(page, "station.station.state.paused")
        shows(console, rows[0], "paused")
        page.keyboard.press("x")
        shows(console, rows[0], "All stop · paused")
        assert "not begun" in console.inner_text(rows[1]) and "All stop" not in console.inner_text(rows[1])
        judge(console, "trainees, one stopped")

        console.goto(console.evaluate(f"document.querySelector('{rows[1]} a').href"))
        shows(console, "#instructor", "m above the bed")
        shows(console, "#title", two.station.present().live.simulator.scenario.name)
        console.fill("[aria-label='Message to the trainee']", "mind the wall")
        console.click("text=Send")
        until(lambda: two.station.present().instruction == "mind the wall", "the message")
        assert one.station.present().instruction == ""
        assert not one.complaints and not two.complaints


def test_a_station_is_added_and_removed_and_a_bad_address_refused(browser, tmp_path):
    with exercise_desk(browser, tmp_path, load_exercise("hover"), instructor_token=TOKEN) as here:
        page = here.open(f"/trainees.html#{TOKEN}", locale="de-DE")
        shows(page, ".trainees tbody", "nicht begonnen")
        page.fill("input", "a b:c")
        page.click("text=Station hinzufügen")
        shows(page, "#toast", "ist nicht die Adresse einer Station")
        page.fill("input", "127.0.0.1:9")
        page.click("text=Station hinzufügen")
        shows(page, ".trainees tbody tr:nth-child(2)", "keine Verbindung")
        judge(page, "trainees in German")
        page.click("text=Entfernen")
        when(page, "document.querySelectorAll('.trainees tbody tr').length === 1 && location.hash.length > 1")
