"""What an atlas is handed on as, from a recorded run of `small_world`: against the truth that was recorded with it."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
import yaml
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message
from whole_runs import hslam, outcome

from hslam_bags.bag import Bag
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.bag_loop import rebuild_atlas
from hslam_bringup.run_options import RunOptions
from hslam_report.landmark_score import rigid_fit
from hslam_ros.conversions import odometry_from_msg
from hslam_sim.worlds import load_world
from hslam_types.se2 import SE2, Array

SAMPLES = Path(__file__).parents[1] / "bags" / "samples"
BAG = SAMPLES / "small_world_1"


@dataclass(frozen=True)
class Sample:
    """The atlas of the recorded run, and what was written of it."""

    atlas: Path
    tum: Array
    """Stamp (s), x, y, then the rest of a pose, one row each."""
    true_places: Array
    """Of the same rows, n x 2."""
    picture_in_world: SE2


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Sample:
    """Return the atlas of the sample with its trajectory, laid on the truth."""
    out = tmp_path_factory.mktemp("sample")
    options = RunOptions("", 0, out)
    with Bag(BAG) as bag:
        rebuild_atlas(bag, options)
        truth = {}
        for message in bag.messages(TopicChoice(("/ground_truth",))):
            told = odometry_from_msg(deserialize_message(message.raw, Odometry))
            truth[round(told.stamp_ns / 1e9, 3)] = told.base_in_odom[:2]
    said = outcome(hslam("export", str(options.atlas), "--to", "tum", "--bag", str(BAG), "--out", str(out / "way.tum")))
    assert said[0] == 0, said
    tum = np.loadtxt(out / "way.tum")
    true_places = np.array([truth[round(stamp, 3)] for stamp in tum[:, 0]])
    return Sample(options.atlas, tum, true_places, rigid_fit(tum[:, 1:3], true_places))


def test_the_trajectory_is_the_true_one(sample: Sample) -> None:
    off = sample.picture_in_world.apply_all(sample.tum[:, 1:3]) - sample.true_places
    assert np.hypot(*off.T).max() < 0.2
    assert len(sample.tum) > 2000, "of 3,062 cycles; the way to the first node belongs to no edge"
    assert np.all(np.diff(sample.tum[:, 0]) > 0.0)
    assert sample.tum[:, 6] ** 2 + sample.tum[:, 7] ** 2 == pytest.approx(np.ones(len(sample.tum)), abs=1e-6)
    # A trajectory's heading: forward most of the time.
    steps = np.diff(sample.tum[:, 1:3], axis=0)
    theta = 2.0 * np.arctan2(sample.tum[:-1, 6], sample.tum[:-1, 7])
    moving = np.hypot(*steps.T) > 0.02
    along = steps[moving, 0] * np.cos(theta[moving]) + steps[moving, 1] * np.sin(theta[moving])
    assert np.mean(along > 0.0) > 0.8


def test_the_map_shows_walls_where_they_are_and_free_space_where_it_is(sample: Sample, tmp_path: Path) -> None:
    out = tmp_path / "floor.yaml"
    status, *_ = outcome(
        hslam("export", str(sample.atlas), "--to", "map", "--bag", str(BAG), "--out", str(out), "--resolution", "0.1")
    )
    assert status == 0
    told = yaml.safe_load(out.read_text())
    grey = read_pgm(tmp_path / told["image"])
    rows, columns = np.indices(grey.shape)
    low = np.array(told["origin"][:2])
    cells = np.stack((columns + 0.5, grey.shape[0] - rows - 0.5), axis=-1) * told["resolution"] + low
    free_space = load_world("small_world", landmark_seed=1).free_space

    def in_world(level: int) -> Any:
        return shapely.points(sample.picture_in_world.apply_all(cells[grey == level]))

    occupied, free = in_world(0), in_world(254)
    assert np.mean(shapely.distance(occupied, free_space.boundary) < 0.25) > 0.9
    assert np.mean(shapely.contains(free_space.buffer(0.15), free)) > 0.98
    assert len(free) * 0.01 > 0.75 * free_space.area
    walls = shapely.segmentize(free_space.boundary, 0.1)
    seen = shapely.distance(shapely.points(shapely.get_coordinates(walls)), shapely.multipoints(occupied)) < 0.3
    assert np.mean(seen) > 0.8


def read_pgm(path: Path) -> npt.NDArray[np.uint8]:
    """Return the grey levels of a binary PGM, the first row the upper one."""
    head, size, most, pixels = path.read_bytes().split(b"\n", 3)
    assert (head, most) == (b"P5", b"255")
    width, height = map(int, size.split())
    return np.frombuffer(pixels, dtype=np.uint8).reshape(height, width)


def test_routes_follow_the_way_driven_where_the_bag_tells_it(sample: Sample, tmp_path: Path) -> None:
    lengths = {}
    for bag in ((), ("--bag", str(BAG))):
        out = tmp_path / f"routes{len(bag)}.geojson"
        status, *_ = outcome(hslam("export", str(sample.atlas), "--to", "geojson", *bag, "--out", str(out)))
        assert status == 0
        features = json.loads(out.read_text())["features"]
        lines = [f["geometry"]["coordinates"][0] for f in features if f["geometry"]["type"] != "Point"]
        lengths[len(bag)] = sum(shapely.LineString(line).length for line in lines) / 2.0
        free_space = load_world("small_world", landmark_seed=1).free_space
        within = [
            free_space.buffer(0.1).contains(shapely.LineString(sample.picture_in_world.apply_all(np.array(line))))
            for line in lines
        ]
    assert all(within), "with the bag: no straight line runs through a wall"
    status, out_text, _ = outcome(hslam("info", str(sample.atlas), "--json"))
    assert status == 0
    driven_m = json.loads(out_text)["length_m"]
    assert abs(lengths[2] - driven_m) < abs(lengths[0] - driven_m)
    assert lengths[2] == pytest.approx(driven_m, rel=0.1)


def test_info_counts_what_is_in_the_file(sample: Sample) -> None:
    status, text, _ = outcome(hslam("info", str(sample.atlas), "--json"))
    fields = json.loads(text)
    assert status == 0
    assert (fields["nodes"], fields["edges"], fields["parts"], fields["unexplored"]) == (4, 4, 1, 0)
    assert fields["drives"] >= 4
    assert fields["shortest_edge_m"] <= fields["longest_edge_m"] < fields["length_m"]
    assert fields["size_mb"] == pytest.approx(sample.atlas.stat().st_size / 1e6, abs=1e-3)


@pytest.mark.parametrize("ending", ["svg", "pdf", "png"])
def test_the_atlas_is_drawn_by_itself_and_the_same_every_time(sample: Sample, tmp_path: Path, ending: str) -> None:
    for name in ("one", "two"):
        out = tmp_path / f"{name}.{ending}"
        status, text, _ = outcome(hslam("plot", str(sample.atlas), "--out", str(out)))
        assert status == 0
        assert "4 nodes, 4 edges" in text
    assert (tmp_path / f"one.{ending}").read_bytes() == (tmp_path / f"two.{ending}").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("export", "--to", "tum", "--out", "x.tum"), "add --bag"),
        (("export", "--to", "map", "--out", "x.pgm"), "must end in .yaml"),
        (("export", "--to", "geojson", "--out", "nowhere/x.json"), "cannot write nowhere/x.json"),
        (("export", "--to", "tum", "--out", "x.tum", "--bag", str(SAMPLES / "small_world_2_heard")), "not the bag"),
        (("plot", "--out", "x.doc"), "must end in one of"),
        (("plot", "--out", "nowhere/x.svg"), "cannot draw"),
    ],
)
def test_what_cannot_be_written_is_one_line(
    sample: Sample, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], what: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, err = outcome(hslam(arguments[0], str(sample.atlas), *arguments[1:]))
    assert status == 1
    assert what in err
    assert err.strip().splitlines()[-1].startswith("hslam: ")
    assert list(tmp_path.iterdir()) == []


def test_no_atlas_is_one_line(tmp_path: Path) -> None:
    status, _, err = outcome(hslam("info", str(tmp_path / "none.db")))
    assert status == 1
    assert "no such file" in err
