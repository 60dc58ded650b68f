"""A packaged exercise by keys alone, from the start screen to its end; axe before and after it."""

import numpy as np

from browser import desk, judge, shows, until, when
from uwsim.operator.station.flights.flights import Bounds

GRIP_M, JAWS_M = (2.78, 0.5, -3.6), (0.44, 0.0, -0.1)  # by the brief; from the vehicle to the middle between its jaws
BEFORE_M = np.subtract(GRIP_M, JAWS_M)
AXES = (("KeyW", "KeyS"), ("KeyA", "KeyD"), ("Space", "KeyB"))
SURE_M, AHEAD_S = 0.02, 0.6  # nearer than this, no key is pressed; for which the pilot thinks ahead
MOVED_M = 0.005  # of jaws that are no longer open
LOOK_S = 0.1  # of simulated time between two looks of the pilot


class Keyboard:
    """A pilot who sees where the vehicle is, and holds the keys that bring it to a place. Time waits for the page."""

    def __init__(self, page, live=None) -> None:
        self.page, self.live = page, live
        self.held: set[str] = set()

    def look(self, sim) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The vehicle's place and velocity [m, m/s], and how far and how fast its jaws have come together [m, m/s]."""
        rov, arm = sim.rov, sim.rov.arm.read()
        return (
            rov.pose.position_world_m.copy(),
            rov.velocity.linear_body_m_s.copy(),
            np.array([arm.positions, arm.speeds]),
        )

    def fly(self, place, is_there, *also: str) -> None:
        """Hold the keys to a place, and others, until `is_there(position, velocity, jaws)`."""
        while not is_there(*(now := self.live.read(self.look).result())):
            off = place - now[0] - AHEAD_S * now[1]
            signs = np.where(np.abs(off) > SURE_M, np.sign(off), 0.0)
            self.hold({*also, *(keys[int(sign < 0)] for keys, sign in zip(AXES, signs, strict=True) if sign)})
            until(lambda signs=signs: (np.sign(self.live.simulator.rov.effort[:3]) == signs).all(), "the keys")
            with self.live.privileged():
                self.live.step(round(LOOK_S / self.live.simulator.step_s))
            assert self.live.simulator.time_s < 170.0, now
        self.hold(set())

    def hold(self, keys: set[str]) -> None:
        for key in sorted(self.held - keys):
            self.page.keyboard.up(key)
        for key in sorted(keys - self.held):
            self.page.keyboard.down(key)
        self.held = keys

    def press(self, key: str, times: int = 1) -> None:
        for _ in range(times):
            self.page.keyboard.press(key)

    def choose(self, selector: str) -> None:
        """Move the focus to a button by Tab, and press it."""
        for _ in range(60):
            if self.page.evaluate("(selector) => document.activeElement.matches(selector)", selector):
                return self.press("Enter")
            self.press("Tab")
        raise AssertionError(f"{selector} gets no focus")


def test_a_packaged_exercise_for_the_arm_is_flown_by_keys_alone_from_the_start_screen(browser, tmp_path):
    with desk(browser, tmp_path, keep_flights=Bounds(2)) as here:
        page = here.open(viewport={"width": 1440, "height": 900})
        page.wait_for_selector("[data-exercise=pin]", state="attached")
        Keyboard(page).choose("[data-task=train]")
        Keyboard(page).choose("[data-exercise=pin] button")
        here.settle(page)
        live = here.station.present().live
        pilot = Keyboard(page, live)
        shows(page, "#exercise", "Time stands still")
        judge(page, "waiting", "#exercise")
        pilot.press("Enter")
        until(lambda: live.tick > 0, "time")
        with live.privileged():
            live.pause()
        pilot.press("Minus", 2)
        pilot.fly(BEFORE_M, lambda at, velocity, _: at[0] > BEFORE_M[0] - 0.03 and abs(velocity[0]) < 0.1)
        pilot.fly(BEFORE_M, lambda _, __, jaws: jaws[0].min() > MOVED_M and abs(jaws[1]).max() < 1e-3, "PageDown")
        pilot.press("Equal", 2)
        pilot.fly(BEFORE_M - [0.6, 0, 0], lambda at, *_: at[0] < BEFORE_M[0] - 0.19)
        shows(page, "#exercise", "80 / 80", 30.0)
        pilot.fly(BEFORE_M - [0.2, 0, 0], lambda _, __, jaws: jaws[0].max() < MOVED_M, "PageUp")
        pilot.fly(np.array([0, 0.5, -3.5]), lambda at, *_: at[0] < 0.45)
        when(page, "document.querySelector('.exercise-sheet')?.checkVisibility()", 30.0)
        shows(page, "#exercise", "100 of 100")
        judge(page, "over")
        pilot.press("Escape")
        pilot.choose("#menu-dialog .stack:last-child button")
        shows(page, "#flights", "exercise: Pull the pin")
        assert not here.complaints
