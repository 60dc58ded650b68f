"""Pictures have the same bits with every instruction set of kernels and Embree."""

import os
import subprocess
import sys
from functools import cache

import pytest

PICTURES = """
import hashlib
from uwsim import Simulator, _core

print(_core.instruction_set())
with Simulator("pool", seed=203) as sim:
    for lamp in sim.rov.lamps.values():
        lamp.on = True
    for name, camera in sim.rov.cameras.items():
        frame = camera.capture(radiance=True)
        for part in ("rgb", "radiance", "depth_m", "normals_world", "labels"):
            print(name, part, hashlib.blake2b(getattr(frame, part).tobytes(), digest_size=8).hexdigest())
"""


@cache
def rendered(instructions: str) -> list[str]:
    """Return the instruction set and a digest of each plane of each picture; skips if the machine lacks it."""
    env = os.environ | {"UWSIM_INSTRUCTION_SET": instructions}
    ran = subprocess.run([sys.executable, "-c", PICTURES], env=env, capture_output=True, text=True, check=False)
    if "this processor does not have it" in ran.stderr:
        pytest.skip(ran.stderr.strip().splitlines()[-1])
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.splitlines()


@pytest.mark.parametrize("wider", ["avx2", "avx512"])
def test_pictures_do_not_depend_on_the_instruction_set(wider: str) -> None:
    """Radiance is compared as well: a difference in its last bits changes a pixel in a picture or two."""
    plain, wide = rendered("portable"), rendered(wider)
    assert (plain[0], wide[0]) == ("portable", wider)
    assert len(plain) == 1 + 3 * 5, "three cameras, five planes"
    assert wide[1:] == plain[1:]
