"""Tests of films: the same frames with any workers, resuming, the camera's paths, and files of others."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import uwsim
from elsewhere import Elsewhere
from uwsim.campaigns.film import Film, make, make_film
from uwsim.campaigns.workers import campaign
from uwsim.missions import goto
from uwsim.recording.filming import shot
from uwsim.recording.filming.shot import FilmCamera, between, developed
from uwsim.recording.filming.views import along_path
from uwsim.scenario.spec.camera import CameraMount

OPTIONS = {"size": (48, 28), "fps": 5.0, "from_s": 2.0, "until_s": 2.6, "workers": 0}


def eastward(vehicle):
    vehicle.undock()
    yield from goto(vehicle, (0, 0, -2.5))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    options = {"sample_sensors": False, "autosave_s": 0.0, "report": "none"}
    uwsim.fly(eastward, "pool", record=path, record_topic=("odom",), time_limit_s=3.0, **options)
    return path


def frames(film: Film) -> list[bytes]:
    return [path.read_bytes() for path in sorted(film.out.with_suffix(".frames").glob("*.png"))]


def test_frames_do_not_depend_on_workers_and_an_interrupted_film_resumes(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = make_film(recording, tmp_path / "whole.webp", **OPTIONS)
    shown: list[int] = []
    options = {**OPTIONS, "tell": lambda finished, failed, count: shown.append(finished)}
    out = tmp_path / "parts.webp"
    part = make_film(recording, out, **options, stop_requested=lambda: bool(shown) and shown[-1] >= 1)
    assert part.interrupted and part.finished == 1 and not out.exists()
    with pytest.raises(ValueError, match="holds a film already: --resume"):
        make_film(recording, out, **options)
    with pytest.raises(ValueError, match=r"fps is 4\.0: was begun with 5\.0"):
        make_film(recording, out, **{**options, "fps": 4.0}, resume=True)
    monkeypatch.setattr(campaign, "open_workers", lambda count, scheduler: Elsewhere(shot._stage.cache_clear))
    rest = make_film(recording, out, **options, resume=True)
    assert rest.made == 2 and not rest.interrupted
    assert frames(rest) == frames(whole) and len(frames(whole)) == 3
    assert out.read_bytes() == (tmp_path / "whole.webp").read_bytes()
    assert Image.open(out).n_frames == 3


def test_a_frame_of_one_picture_is_the_cameras_own() -> None:
    with uwsim.Simulator("pool") as sim:
        sim.rov.release()
        own = sim.rov.cameras["front"].resized(64, 36)
        without = ("noise", "vignetting", "shutter")
        frame = own.capture(without=without, radiance=True)
        alike = developed(frame.radiance.astype(np.float64) * frame.gain).astype(int) - frame.rgb
        assert np.abs(alike).max() <= 1  # the core's power function is an approximation
        mount = own.mount.model_copy(update={"position_m": (0.0, 0.0, 0.0), "yaw_pitch_roll_deg": (0.0, 0.0, 0.0)})
        film = FilmCamera(
            CameraMount.model_validate(mount.model_dump()), own.scene, np.concatenate(own.pose), own.hidden
        )
        seen = film.capture(without=(*without, "wobble"), radiance=True)
        assert np.array_equal(seen.rgb, own.capture(without=(*without, "wobble")).rgb)


def test_a_state_between_two_has_the_mean_place_and_turn() -> None:
    with uwsim.Simulator("pool") as sim:
        sim.rov.release()
        camera = sim.rov.cameras["front"]
        one = camera.snapshot()
        sim.rov.place((1.0, 0.0, -2.0), (0.0, 0.0, -np.sin(0.5), -np.cos(0.5)))
        two = camera.snapshot()
    middle = between((one, two), 0.5)
    assert middle.positions_m[0] == pytest.approx(0.5 * (one.positions_m[0] + two.positions_m[0]))
    assert one.orientations_xyzw[0] == pytest.approx((0, 0, 0, 1))
    assert middle.orientations_xyzw[0] == pytest.approx((0, 0, np.sin(0.25), np.cos(0.25)))


def test_a_path_is_followed(tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    path.write_text("time_s,x_m,y_m,z_m,at_x_m,at_y_m,at_z_m\n0,-2,0,-3,3,0,-3\n10,0,0,-3,0,5,-3\n")
    poses = along_path(path, np.array([0.0, 5.0, 10.0]))
    assert poses[:, :3] == pytest.approx(np.array([[-2, 0, -3], [-1, 0, -3], [0, 0, -3]]))
    yaws = 2 * np.arctan2(poses[:, 5], poses[:, 6])
    assert yaws == pytest.approx([0.0, np.arctan2(2.5, 2.5), np.pi / 2])
    path.write_text("time_s,x_m,y_m,z_m,at_x_m,at_y_m,at_z_m\n5,-2,0,-3,3,0,-4.5\n1,0,0,-3,3,0,-4.5\n")
    with pytest.raises(ValueError, match="must have rows with times that ascend"):
        along_path(path, np.zeros(1))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"camera": "nose"}, "camera = 'nose': must be one of chase, orbit, front, "),
        ({"quality": "best"}, "quality = 'best': must be one of draft, good, high"),
        ({"until_s": 1.0}, "until = 1 s: must be above --from = 2 s"),
        ({"from_s": 50.0, "until_s": 60.0}, "ends before from = 50 s"),
        ({"from_s": 2.0, "until_s": 2.1}, "has less than a frame between from = 2 s and until = 2.1 s"),
        ({"size": (0, 28)}, r"size = 0 pixels: must be in \[1, 8192\]"),
    ],
)
def test_mistakes_are_reported(recording: Path, tmp_path: Path, options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_film(recording, tmp_path / "film.webp", **{**OPTIONS, **options})


def test_a_file_of_another_program_stays(recording: Path, tmp_path: Path) -> None:
    theirs = tmp_path / "film.webp"
    theirs.write_bytes(b"theirs")
    with pytest.raises(FileExistsError, match="uwsim did not write it"):
        make_film(recording, theirs, **OPTIONS)
    assert theirs.read_bytes() == b"theirs" and not theirs.with_suffix(".frames").exists()
    frame = tmp_path / "other.frames" / "000002.png"
    frame.parent.mkdir()
    frame.write_bytes(b"theirs")
    with pytest.raises(FileExistsError, match="uwsim did not write it"):
        make_film(recording, tmp_path / "other.webp", **OPTIONS)
    assert frame.read_bytes() == b"theirs" and list(frame.parent.iterdir()) == [frame]


def test_a_film_of_another_flight_is_not_resumed(tmp_path: Path) -> None:
    mission, out = tmp_path / "mission.py", tmp_path / "film.webp"
    text = "from uwsim.missions import wait\n\n\ndef mission(vehicle):\n    yield wait({:g})\n"
    mission.write_text(text.format(1.0))
    options = {"size": (8, 8), "fps": 5.0, "until_s": 0.4, "workers": 0, "scenario": "pool", "quality": "draft"}
    assert make_film(mission, out, **options, stop_requested=lambda: True).interrupted
    mission.write_text(text.format(2.0))
    with pytest.raises(ValueError, match=r"flight is mission.py \([0-9a-f]{16}\) in pool until 0.4 s: was begun with"):
        make_film(mission, out, **options, resume=True)


def test_a_film_has_many_frames_of_which_few_are_open(tmp_path: Path) -> None:
    frames = [tmp_path / f"{k:06d}.png" for k in range(40)]
    for k, path in enumerate(frames):
        Image.new("RGB", (8, 8), (255 * (k % 2),) * 3).save(path)
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    opened = len(list(Path("/proc/self/fd").iterdir()))
    resource.setrlimit(resource.RLIMIT_NOFILE, (opened + 20, limits[1]))
    try:
        make._write_webp(tmp_path / "film.webp", frames, 25.0)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    with Image.open(tmp_path / "film.webp") as film:
        assert film.n_frames == 40
        film.seek(39)
        assert min(film.convert("RGB").getpixel((4, 4))) > 240
