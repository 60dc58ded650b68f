"""Other people's libraries have the same sea water, rigid body and camera."""

from importlib import import_module

import pytest

from uwsim.evidence.validate import peers
from uwsim.evidence.validate.peers import occupancy


@pytest.mark.parametrize("peer", peers.PEERS)
def test_a_peer_agrees(peer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(occupancy, "SCANS", 4)  # tools/docs runs all 20, which take 10 s
    package, distribution = peers.PEERS[peer]
    pytest.importorskip(package, reason=f"pip install {distribution}")
    checks = import_module(f"uwsim.evidence.validate.peers.{peer}").checks()
    assert checks and [check for check in checks if not check.passed] == []


def test_a_missing_peer_is_reported_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "PEERS", {"absent": ("no_such_package", "no-such-distribution")})
    refused = pytest.raises(ValueError, match="no peer is installed; pip install no-such-distribution")
    with pytest.warns(UserWarning, match="absent is left out: pip install no-such-distribution"), refused:
        peers.run()
