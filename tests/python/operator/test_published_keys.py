"""The driving keys are those of the published keyboard node, and add up where the pilot chooses so."""

from uwsim.operator.teleop.hands import DRIVING, ZERO, Hands

PUBLISHED = {"w": "surge", "s": "-surge", "d": "-sway", "a": "sway", " ": "heave", "b": "-heave", "i": "pitch",
             "k": "-pitch", "l": "roll", "j": "-roll", "e": "-yaw", "q": "yaw"}  # fmt: skip
"""key_publisher.py of the published simulator; its wire's sway and yaw are positive to starboard, here to port."""


def test_the_driving_keys_are_those_of_the_published_node():
    assert {key: "-" * (sign < 0) + axis for key, (axis, sign) in DRIVING.items()} == PUBLISHED


def test_published_keys_add_up_until_the_opposite_key():
    hands = Hands(adds_up=True)
    for key, expected in (("w", 1), ("w", 1), ("s", 0), ("s", -1), ("s", -1), ("w", 0), ("w", 1)):
        hands.press(key)
        assert hands.efforts()["surge"] == expected * hands.share
    hands.press("c")
    assert hands.efforts() == ZERO
