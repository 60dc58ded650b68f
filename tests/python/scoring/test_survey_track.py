"""The track file of a survey."""

import numpy as np
import pytest

from uwsim.scoring.survey_track import SurveyTrack

INTERNALS = ("zip", "zlib", "pickle", "CRC", "EOF", "descr", "header", "reshape", "NumPy", "numpy")


def test_a_track_is_read_as_written_and_a_damaged_one_is_refused(tmp_path):
    path = tmp_path / "track.npz"
    track = SurveyTrack(
        np.random.default_rng(0).normal(size=(50, 3)), np.array([[0.0, 0], [1, 0], [0, 1]]), 54.9, "pool"
    )
    track.write(path)
    back = SurveyTrack.read(path)
    assert np.array_equal(back.path_world_m, track.path_world_m)
    assert np.array_equal(back.area_world_m, track.area_world_m)
    assert (back.range_max_m, back.scenario_name) == (54.9, "pool")
    whole = path.read_bytes()
    track.write(path)
    assert path.read_bytes() == whole
    random = np.random.default_rng(1)
    for trial in range(60):
        data = bytearray(whole)
        if trial % 2:
            del data[random.integers(len(data)) :]
        else:
            data[random.integers(len(data))] ^= 0xFF
        path.write_bytes(bytes(data))
        try:
            SurveyTrack.read(path)
        except ValueError as error:
            assert "not a valid track" in str(error)
            assert not any(word in str(error) for word in INTERNALS), "messages are about the file, not about libraries"
    path.unlink()  # uwsim replaces no file that was changed by others
    for bad in (
        SurveyTrack(np.full((2, 3), np.nan), track.area_world_m, 10.0),
        SurveyTrack(np.zeros((2, 2)), track.area_world_m, 10.0),
        SurveyTrack(np.zeros((2, 3)), track.area_world_m[:2], 10.0),
        SurveyTrack(np.zeros((2, 3)), track.area_world_m, -1.0),
    ):
        bad.write(path)
        with pytest.raises(ValueError, match="not a valid track"):
            SurveyTrack.read(path)


def test_another_kind_of_file_is_refused_in_words_that_a_user_knows(tmp_path):
    path = tmp_path / "track.npz"
    for content in (b"", b"# a cloud, perhaps\n1 2 3\n", b"PK\x03\x04 and no more"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match="it is damaged, or another kind of file"):
            SurveyTrack.read(path)
    path.unlink()
    np.savez(path, version=np.int64(1), path_world_m=np.zeros((2, 3)))
    with pytest.raises(ValueError, match="it has no 'area_world_m'"):
        SurveyTrack.read(path)
