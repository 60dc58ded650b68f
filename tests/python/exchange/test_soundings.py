"""`uwsim scenario from` soundings: x y z as text or LAS, on a grid or scattered, become the bed that was sounded."""

from pathlib import Path

import numpy as np
import pytest

from command_line import uwsim as command
from uwsim.exchange.soundings import read_soundings, scattered
from uwsim.mapping.files.cloud_files import write_cloud
from uwsim.scenario import build_world, load

AT = np.array([500_000.0, 4_000_000.0])


def bed(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return -20.0 + 0.02 * (x - AT[0]) - 0.03 * (y - AT[1])


def points(seed: int | None) -> np.ndarray:
    """Soundings of a sloping bed, 200 m across: on a grid of 2 m, or scattered."""
    if seed is None:
        x, y = (each.ravel() for each in np.meshgrid(np.arange(101) * 2.0, np.arange(101) * 2.0))
    else:
        x, y = np.random.default_rng(seed).uniform(0.0, 200.0, (2, 20_000))
    x, y = x + AT[0], y + AT[1]
    return np.column_stack([x, y, bed(x, y)])


def text(values: np.ndarray, separator: str, head: str = "", decimal: str = ".") -> str:
    rows = [separator.join(f"{value:.3f}".replace(".", decimal) for value in row) for row in values]
    return "\n".join([*([head] if head else []), *rows]) + "\n"


def heights(path: Path, folder: Path, *options: str) -> tuple[np.ndarray, str]:
    """The bed's heights in the scenario that soundings become, over what they should be; and what was printed."""
    out = folder / "made.yaml"
    done = command("scenario", "from", path, "--out", out, "--crs", "EPSG:32632", *options)
    assert done.returncode == 0, done.stderr
    scenario = load(out)
    assert (folder / "made.tif").is_file()
    middle = np.array(scenario.terrain.centre)
    at = np.array([[0.0, 0.0], [40.0, 0.0], [0.0, -40.0], [-30.0, 50.0]])
    return build_world(scenario).height_at(at) - bed(*(middle + at).T), done.stdout


FORMS = {
    "spaces.xyz": (None, lambda found: text(found, " "), ()),
    "scattered.xyz": (3, lambda found: "# a comment\n" + text(found, "\t"), ()),
    "semicolons.txt": (3, lambda found: text(found, ";", decimal=","), ()),
    "named.csv": (3, lambda found: text(np.c_[found[:, [2, 1, 0]] * (-1, 1, 1), found[:, 2]], ",",
                                        "depth,northing,easting,beam"), ()),
    "units.dat": (3, lambda found: text(np.c_[found[:, 2] * 0, found[:, [1, 0, 2]]], ",",
                                        "date,Northing_m,UTM_E (m),z_corrected"), ()),
    "commented.txt": (3, lambda found: "# made by hand\n# y,x,z\n" + text(found[:, [1, 0, 2]], " "), ()),
    "counted.xyz": (3, lambda found: text(np.c_[range(len(found)), found], " ").replace(".000 ", " "), ()),
    "r.txt": (3, lambda found: "y x z\n" + "".join(f'"{k}" {y:.3f} {x:.3f} {z:.3f}\n' for k, (x, y, z) in
                                                   enumerate(found)), ()),
    "down.dat": (None, lambda found: text(found * (1, 1, -1), " "), ("--positive", "down")),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMS)
def test_soundings_of_any_form_become_the_bed_that_they_were_taken_of(name: str, tmp_path: Path) -> None:
    seed, written, options = FORMS[name]
    (tmp_path / name).write_text(written(points(seed)))
    off_m, printed = heights(tmp_path / name, tmp_path, *options)
    np.testing.assert_allclose(off_m, 0.0, atol=0.01 if seed is None else 0.1)
    assert ("on a regular grid" in printed) == (seed is None) and ("left out: columns beam" in printed) == (
        "csv" in name
    )


def test_soundings_in_las_are_read_as_well(tmp_path: Path) -> None:
    write_cloud(tmp_path / "a.las", points(5))
    off_m, printed = heights(tmp_path / "a.las", tmp_path, "--cell", "4")
    np.testing.assert_allclose(off_m, 0.0, atol=0.1)
    assert "the median of each cell of 4" in printed


@pytest.mark.parametrize("columns", [(0, 1, 2), (1, 0, 2)])
def test_latitude_before_longitude_is_known_by_its_name_or_by_its_range(
    columns: tuple[int, ...], tmp_path: Path
) -> None:
    found = points(7)
    found[:, :2] = (found[:, :2] - AT) * (1.0 / 90_000.0, 1.0 / 111_000.0) + (-122.0, 36.0)
    names = np.array(["lon", "lat", "depth"])
    for name, head in (("named", " ".join(names[list(columns)]) + "\n"), ("bare", "")):
        rows = (found * (1, 1, -1 if head else 1))[:, columns]
        (tmp_path / f"{name}.txt").write_text(head + "".join("{:.7f} {:.7f} {:.3f}\n".format(*row) for row in rows))
        done = command("scenario", "from", tmp_path / f"{name}.txt", "--out", tmp_path / f"{name}.yaml")
        assert done.returncode == 0, done.stderr
        longitude, latitude = load(tmp_path / f"{name}.yaml").terrain.centre
        assert (longitude, latitude) == pytest.approx((-122.0 + 100 / 90_000, 36.0 + 100 / 111_000), abs=1e-4)


def test_degrees_are_taken_for_such_and_wide_gaps_stay_gaps(tmp_path: Path) -> None:
    found = points(7)
    found = found[(found[:, 0] < AT[0] + 80.0) | (found[:, 0] > AT[0] + 140.0)]
    found[:, :2] = (found[:, :2] - AT) * (1.0 / 80_000.0, 1.0 / 111_000.0) + (5.0, 44.0)
    path = tmp_path / "a.xyz"
    path.write_text("".join(f"{x:.7f} {y:.7f} {z:.3f}\n" for x, y, z in found))
    done = command("scenario", "from", path, "--out", tmp_path / "made.yaml")
    assert done.returncode == 0, done.stderr
    assert "assumed: x and y are longitude and latitude, EPSG:4326" in done.stdout
    assert load(tmp_path / "made.yaml").terrain.size_m[0] < 90.0  # beside the gap


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "is empty: must have lines of x, y, z"),
        ("1 2 3\n4 5\n", "line 2: '4 5': must have numbers x, y, z"),
        ("1 2 3\n4 5 nan\n", "line 2: '4 5 nan': must have numbers x, y, z"),
        ("a,b,c\n1,2,3\n", "must name x, y and z"),
        ("1 2 3\n4 5 6\n", "has 2 soundings: must have 9 or more"),
        ("".join(f"{k} 0 -5\n" for k in range(20)), "not in a line"),
        ("".join(f"{k} {k} -5\n" for k in range(200)), "has 200 soundings: must have 9 or more, not in a line"),
        ("x,y,z\n", "has 0 soundings: must have 9 or more"),
        ("".join(f"{k % 20} {k // 20} 5\n" for k in range(400)), "if they are depths, give --positive down"),
    ],
)
def test_what_is_no_sounding_is_named_and_nothing_is_written(content: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text(content)
    done = command("scenario", "from", tmp_path / "a.xyz", "--crs", "local", "--out", tmp_path / "made.yaml")
    assert done.returncode == 1 and words in done.stderr and len(done.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["a.xyz"]


def test_cells_in_a_line_are_refused_in_one_line() -> None:
    found = np.arange(40.0)[:, None] * (2.0, 2.0, 1.0) + np.random.default_rng(1).uniform(-0.1, 0.1, (40, 3))
    with pytest.raises(ValueError, match=r"^'a.xyz': has 40 soundings in a line: must cover an area$"):
        scattered(Path("a.xyz"), found, 1.0, 1.0)


def test_a_table_of_another_kind_is_no_sounding(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time_s,depth\n1,2\n")
    with pytest.raises(ValueError, match="its first line is 'time_s depth': must name x, y and z"):
        read_soundings(path)
