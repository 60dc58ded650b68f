"""The suites of `uwsim validate`, by name, with their modules; the command line reads them without importing them."""

SUITES = {
    "dynamics": "uwsim.evidence.validate.dynamics",
    "tether": "uwsim.evidence.validate.tether",
    "sonar": "uwsim.evidence.validate.sonar",
    "imaging": "uwsim.evidence.validate.imaging",
    "camera": "uwsim.evidence.validate.camera",
    "link": "uwsim.evidence.validate.link",
    "sound": "uwsim.evidence.validate.sound",
    "control": "uwsim.evidence.validate.control",
    "estimation": "uwsim.evidence.validate.estimation",
    "navigation": "uwsim.evidence.validate.navigation",
    "identification": "uwsim.evidence.validate.identification",
    "flights": "uwsim.evidence.validate.logged_flights",
    "reality": "uwsim.evidence.validate.reality",
    "peers": "uwsim.evidence.validate.peers",
}
RECORDED = ("sound", "flights", "reality")
ON_REQUEST = ("flights", "reality", "peers")
"""Suites that need data or additional packages."""
