"""The suites of `uwsim validate`, by name, with their modules; the command line reads them without importing them."""

SUITES = {
    "dynamics": "uwsim.evidence.validate.motion.suite",
    "tether": "uwsim.evidence.validate.peers.tethers",
    "sonar": "uwsim.evidence.validate.sonars.multibeam",
    "imaging": "uwsim.evidence.validate.sonars.imaging",
    "camera": "uwsim.evidence.validate.camera",
    "link": "uwsim.evidence.validate.link",
    "sound": "uwsim.evidence.validate.sound",
    "control": "uwsim.evidence.validate.control",
    "estimation": "uwsim.evidence.validate.navigator.estimation",
    "navigation": "uwsim.evidence.validate.navigator.by_place",
    "identification": "uwsim.evidence.validate.identification",
    "flights": "uwsim.evidence.validate.logged_flights",
    "reality": "uwsim.evidence.validate.reality",
    "peers": "uwsim.evidence.validate.peers",
}
RECORDED = ("flights", "reality")
ON_REQUEST = (*RECORDED, "peers")
"""Suites that need data, or additional packages."""
