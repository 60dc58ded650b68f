"""Point cloud files: they round-trip, PCL's own files are read, damaged ones are refused."""

import re
from pathlib import Path

import laspy
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from uwsim.mapping.files import CLOUD_FORMATS, read_cloud, write_cloud

DATA = Path(__file__).parents[1] / "data"
SUFFIXES = sorted(CLOUD_FORMATS.keys() - {".laz"})  # whose reader is a process
finite = st.floats(-1e5, 1e5, width=32)


def some_points(n: int, scale: float = 100.0) -> np.ndarray:
    return np.random.default_rng(n).normal(0.0, scale, (n, 3)).astype(np.float32)


def pcl_points() -> np.ndarray:
    i = np.arange(60)
    f = np.float32
    return np.stack([f(0.1) * (i % 10).astype(f), f(-1) - (i // 10).astype(f), f(-20) + f(0.3) * ((7 * i) % 5)], axis=1)


@pytest.mark.parametrize("suffix", [".pcd", ".ply", ".xyz"])
@settings(max_examples=20)
@given(rows=st.lists(st.tuples(finite, finite, finite), min_size=1, max_size=30))
def test_float32_points_are_preserved_bit_for_bit(suffix, rows, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / f"cloud{suffix}"
    points = np.array(rows, np.float32)
    write_cloud(path, points)
    back = read_cloud(path)
    assert back.dtype == np.float64
    assert back.astype(np.float32).tobytes() == points.tobytes()


def test_xyz_preserves_float64_too(tmp_path):
    points = np.random.default_rng(1).normal(0.0, 5e6, (500, 3))
    write_cloud(tmp_path / "cloud.xyz", points)
    assert np.array_equal(read_cloud(tmp_path / "cloud.xyz"), points)


@pytest.mark.parametrize("suffix", [".pcd", ".ply"])
def test_points_that_a_float32_would_move_are_stored_as_float64(suffix, tmp_path):
    points = np.random.default_rng(1).normal([456_789.0, 5_432_100.0, -60.0], 500.0, (500, 3))
    write_cloud(tmp_path / f"cloud{suffix}", points)
    assert np.array_equal(read_cloud(tmp_path / f"cloud{suffix}"), points)


def test_a_laz_holds_the_points_of_its_las_and_a_damaged_one_is_refused_in_one_line(tmp_path):
    points = np.random.default_rng(2).normal([456_789.0, 5_432_100.0, -60.0], 500.0, (500, 3))
    for suffix in (".las", ".laz"):
        write_cloud(tmp_path / f"cloud{suffix}", points)
    assert np.array_equal(read_cloud(tmp_path / "cloud.laz"), read_cloud(tmp_path / "cloud.las"))
    whole = (tmp_path / "cloud.laz").read_bytes()
    for damaged in (whole[:-60], whole[:300], whole[:107] + b"\xff\xff\xff\x7f" + whole[111:], b""):
        (tmp_path / "bad.laz").write_bytes(damaged)
        with pytest.raises(ValueError, match=r"^'.*bad\.laz': not a valid LAZ file: [^\n]+$"):
            read_cloud(tmp_path / "bad.laz")


def test_a_cloud_is_read_by_its_content_whatever_its_name(tmp_path):
    for suffix in CLOUD_FORMATS:
        write_cloud(tmp_path / f"cloud{suffix}", [[1, 2, 3], [4.5, 5, 6]])
        for other in (".txt", *CLOUD_FORMATS):
            misnamed = (tmp_path / f"cloud{suffix}").rename(tmp_path / f"misnamed{other}")
            assert read_cloud(misnamed).tolist() == [[1, 2, 3], [4.5, 5, 6]]
            misnamed.rename(tmp_path / f"cloud{suffix}")
    (tmp_path / "cloud.txt").write_text("x y z\n1 2 3\n")
    with pytest.raises(ValueError, match=r"cloud.txt': must be a PCD file, a PLY file, .*a XYZ file"):
        read_cloud(tmp_path / "cloud.txt")


def test_las_preserves_millimetres_far_from_zero(tmp_path):
    points = np.random.default_rng(2).normal([456_789.0, 5_432_100.0, -60.0], 500.0, (500, 3))
    write_cloud(tmp_path / "cloud.las", points)
    assert np.abs(read_cloud(tmp_path / "cloud.las") - points).max() <= 0.0005 + 1e-8
    with laspy.open(tmp_path / "cloud.las") as file:
        assert file.header.point_count == 500
        assert str(file.header.version) == "1.2"
        assert file.header.mins == pytest.approx(points.min(axis=0), abs=0.001)
    with pytest.raises(ValueError, match=r"LAS holds at most 2.14748e\+06 m"):
        write_cloud(tmp_path / "wide.las", [[0.0, 0.0, 0.0], [3e6, 0.0, 0.0]])


@pytest.mark.parametrize("name", ["pcl_ascii.pcd", "pcl_binary.pcd", "pcl_compressed.pcd"])
def test_pcls_own_pcd_files_are_read_without_the_nan_point(name):
    assert read_cloud(DATA / name) == pytest.approx(np.delete(pcl_points(), 7, axis=0), abs=2e-6)


def test_the_three_encodings_of_a_pcd_hold_the_same_numbers():
    binary = read_cloud(DATA / "pcl_binary.pcd")
    assert np.array_equal(read_cloud(DATA / "pcl_compressed.pcd"), binary)
    assert read_cloud(DATA / "pcl_ascii.pcd") == pytest.approx(binary, abs=2e-6)


@pytest.mark.parametrize("name", ["pcl_ascii.ply", "pcl_binary.ply"])
def test_pcls_own_ply_files_are_read(name):
    assert read_cloud(DATA / name) == pytest.approx(pcl_points(), abs=2e-6)


def test_other_fields_and_padding_are_skipped(tmp_path):
    layout = [("ring", "<u2"), ("_", "u1", (3,)), ("z", "<f8"), ("x", "<f4"), ("rgb", "<u4"), ("y", "<i2")]
    rows = np.zeros(2, layout)
    rows["x"], rows["y"], rows["z"] = [1.5, -2.5], [3, -4], [0.1, 1e6]
    header = "FIELDS ring _ z x rgb y\nSIZE 2 1 8 4 4 2\nTYPE U U F F U I\nCOUNT 1 3 1 1 1 1\nWIDTH 1\nHEIGHT 2\n"
    (tmp_path / "b.pcd").write_bytes(header.encode() + b"POINTS 2\nDATA binary\n" + rows.tobytes())
    text = "".join(f"7 1 2 3 {row['z']} {row['x']} 9 {row['y']}\n" for row in rows)
    (tmp_path / "a.pcd").write_text(f"{header}DATA ascii\n{text}")
    for name in ("a.pcd", "b.pcd"):
        assert read_cloud(tmp_path / name).tolist() == [[1.5, 3.0, 0.1], [-2.5, -4.0, 1e6]]


def test_trimesh_reads_the_points_of_a_ply_and_we_read_its(tmp_path):
    write_cloud(tmp_path / "cloud.ply", some_points(17))
    cloud = trimesh.load(tmp_path / "cloud.ply")
    assert np.array_equal(cloud.vertices, some_points(17))
    for encoding in ("ascii", "binary"):
        (tmp_path / "its.ply").write_bytes(cloud.export(file_type="ply", encoding=encoding))
        assert read_cloud(tmp_path / "its.ply") == pytest.approx(some_points(17), rel=1e-6)


def test_a_ply_of_doubles_in_the_other_byte_order_with_faces_and_colours_is_read(tmp_path):
    header = (
        "ply\nformat binary_big_endian 1.0\ncomment by hand\nelement vertex 3\nproperty uchar red\nproperty double z\n"
        "property double x\nproperty double y\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(3, [("red", "u1"), ("z", ">f8"), ("x", ">f8"), ("y", ">f8")])
    rows["x"], rows["y"], rows["z"] = [0.1, 2, 3], [4, 5, 6], [7, 8, 1e6 + 0.1]
    face = b"\3" + np.array([0, 1, 2], ">i4").tobytes()
    (tmp_path / "big.ply").write_bytes(header.encode() + rows.tobytes() + face)
    assert read_cloud(tmp_path / "big.ply").tolist() == [[0.1, 4, 7], [2, 5, 8], [3, 6, 1e6 + 0.1]]


def test_text_may_have_commas_comments_and_more_columns(tmp_path):
    (tmp_path / "cloud.xyz").write_text("# x y z intensity\n1,2,3,99\n4\t5 6 98\n\n")
    assert read_cloud(tmp_path / "cloud.xyz").tolist() == [[1, 2, 3], [4, 5, 6]]
    (tmp_path / "cloud.xyz").write_text("")
    assert read_cloud(tmp_path / "cloud.xyz").shape == (0, 3)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_points_give_the_same_bytes_and_sequences_are_accepted(suffix, tmp_path):
    for name in ("a", "b"):
        write_cloud(tmp_path / f"{name}{suffix}", [[1, 2, 3], [4.5, 5, 6]])
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()
    assert read_cloud(tmp_path / f"a{suffix}").tolist() == [[1, 2, 3], [4.5, 5, 6]]


@pytest.mark.filterwarnings("ignore:.*may be cut short:UserWarning")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_damaged_file_gives_a_valueerror_that_names_it_or_another_cloud(suffix, tmp_path):
    path = tmp_path / f"cloud{suffix}"
    write_cloud(path, some_points(40))
    sources = [path.read_bytes(), *(f.read_bytes() for f in sorted(DATA.glob(f"*{suffix}")))]
    random = np.random.default_rng(5)
    refused = 0
    for trial in range(400):
        data = bytearray(sources[trial % len(sources)])
        if trial % 3 == 0:
            del data[random.integers(len(data)) :]
        else:
            head = min(len(data), 400) if trial % 3 == 1 else len(data)
            for at in random.integers(head, size=random.integers(1, 6)):
                data[at] = random.integers(256)
        path.write_bytes(bytes(data))
        try:
            points = read_cloud(path)
        except ValueError as error:
            kind = "LA[SZ]" if suffix == ".las" else suffix[1:].upper()  # by one bit
            assert re.match(f"'{re.escape(str(path))}': not a valid {kind} file: ", str(error))
            assert "\n" not in str(error)
            refused += 1
        else:
            assert points.ndim == 2
            assert points.shape[1] == 3
            assert np.isfinite(points).all()
    assert refused > 100


@pytest.mark.parametrize("suffix", [".pcd", ".ply", ".las"])
def test_a_truncated_file_is_refused(suffix, tmp_path):
    path = tmp_path / f"cloud{suffix}"
    write_cloud(path, some_points(100))
    whole = path.read_bytes()
    for keep in (0, 10, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:keep])
        with pytest.raises(ValueError, match="not a valid"):
            read_cloud(path)


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".ply", "ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nend_header\n1\n"),
        (".pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 999999999999\nDATA binary\n1234"),
        (".pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 999999999999\nDATA ascii\n1 2 3\n"),
        (".pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 0\nDATA ascii\n"),
        (".pcd", "FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 0\nDATA ascii\n"),
        (".pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA zipped\n"),
        (".xyz", "1 2 three\n"),
        (".xyz", "1 2\n"),
    ],
)
def test_a_header_that_does_not_match_its_data_is_refused(suffix, text, tmp_path):
    path = tmp_path / f"cloud{suffix}"
    path.write_text(text)
    with pytest.raises(ValueError, match="not a valid"):
        read_cloud(path)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.empty((0, 3)), "no points to write"),
        ([[1.0, 2.0]], r"shape = \(1, 2\): expected \(n, 3\)"),
        ([[1.0, 2.0, np.nan]], r"points_m\[0\] = .* must be finite"),
        ([[0, 0, 0], [1.0, np.inf, 0]], r"points_m\[1\]"),
        ([["a", "b", "c"]], "must be real numbers"),
        (np.ones((2, 3), complex), "must be real numbers"),
    ],
)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_invalid_cloud_is_not_written(suffix, points, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        write_cloud(tmp_path / f"cloud{suffix}", points)
    assert not any(tmp_path.iterdir())


def test_errors_name_the_path(tmp_path):
    with pytest.raises(ValueError, match=r"must end in \.las, \.pcd|must end in \.pcd"):
        write_cloud(tmp_path / "cloud.e57", some_points(3))
    with pytest.raises(OSError, match=r"nowhere.cloud\.ply': cannot be written: No such file"):
        write_cloud(tmp_path / "nowhere" / "cloud.ply", some_points(3))
    with pytest.raises(OSError, match=r"cloud\.ply': cannot be read: No such file"):
        read_cloud(tmp_path / "cloud.ply")
    assert not any(tmp_path.iterdir())


def test_a_text_that_ends_within_a_number_is_said(tmp_path):
    path = tmp_path / "cut.pcd"
    path.write_bytes((DATA / "pcl_ascii.pcd").read_bytes().rstrip()[:-1])
    with pytest.warns(UserWarning, match=r"cut\.pcd': its last line, .* may be cut short"):
        read_cloud(path)
