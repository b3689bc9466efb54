"""Floor plans: what is drawn is what comes out, and what is wrong is named."""

import math
from pathlib import Path

import numpy as np
import pytest
import shapely

from hslam_sim import floor_plan
from hslam_sim.world import World, WorldError
from hslam_sim.worlds import load_world, shipped_worlds
from hslam_types.se2 import SE2

PLAN = {
    "features": {
        "door": {"shape": "recess", "width": 1.0, "depth": 0.2},
        "pilaster": {"shape": "pilaster", "width": 0.3, "depth": 0.25},
    },
    "corridors": [{"name": "main", "width": 2.0, "line": [[0, 0], [10, 0], [10, 8]]}],
    "start": {"x": 1.0, "y": 0.0, "heading_deg": 90.0},
}


def test_a_bent_corridor_has_square_corners_and_ends() -> None:
    space = floor_plan.free_space(PLAN)
    assert space.area == pytest.approx(11 * 2 + 7 * 2)
    assert space.bounds == pytest.approx((0.0, -1.0, 11.0, 8.0))


@pytest.mark.parametrize(("side", "inside"), [("left", (4.0, 1.1)), ("right", (4.0, -1.1))])
def test_a_recess_lies_behind_the_wall_of_its_side(side: str, inside: tuple[float, float]) -> None:
    corridor = {**PLAN["corridors"][0], side: {"door": [4.0]}}  # type: ignore[index]
    space = floor_plan.free_space({**PLAN, "corridors": [corridor]})
    assert space.contains(shapely.Point(inside))
    assert space.area == pytest.approx(36.0 + 0.2)


def test_a_pilaster_takes_from_the_corridor_after_its_bend() -> None:
    corridor = {**PLAN["corridors"][0], "right": {"pilaster": [14.0]}}  # type: ignore[index]
    space = floor_plan.free_space({**PLAN, "corridors": [corridor]})
    assert space.area == pytest.approx(36.0 - 0.3 * 0.25)
    assert not space.contains(shapely.Point(10.9, 4.0))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"corridor": []}, "unknown key 'corridor'"),
        ({"corridors": [{"name": "a", "width": 2, "line": [[0, 0], [5, 0]], "left": {"gate": [1]}}]}, "'gate'"),
        ({"corridors": [{"name": "a", "width": 2, "line": [[0, 0], [5, 0]], "left": {"door": [9]}}]}, "5 m long"),
        ({"corridors": [{"name": "a", "width": 2, "line": [[0, 0]]}]}, "at least two"),
        ({"rooms": [[[50, 50], [51, 50], [51, 51]]]}, "one connected floor"),
        ({"corridors": []}, "one connected floor"),
    ],
)
def test_what_is_wrong_with_a_plan_is_named(change: dict[str, object], says: str) -> None:
    with pytest.raises(WorldError, match=says):
        floor_plan.free_space({**PLAN, **change})


def test_walls_have_free_space_on_their_left() -> None:
    world = load_world("small_world")
    middle = (world.walls[:, :2] + world.walls[:, 2:]) / 2.0
    along = world.walls[:, 2:] - world.walls[:, :2]
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    probe = middle + 0.01 * left
    assert shapely.contains_xy(world.free_space, probe[:, 0], probe[:, 1]).all()


def test_a_start_outside_is_refused() -> None:
    with pytest.raises(WorldError, match="not in free space"):
        World("box", shapely.box(0, 0, 4, 4), SE2(5.0, 1.0, 0.0), np.empty((0, 2)))


def test_the_papers_floor_has_its_size_and_its_loop() -> None:
    world = load_world("wean_hall_6")
    min_x, min_y, max_x, max_y = shapely.box(*world.free_space.bounds).buffer(-0.8, join_style="mitre").bounds
    assert (max_x - min_x) * (max_y - min_y) == pytest.approx(5000.0, rel=0.05)
    assert len(world.free_space.interiors) == 4
    assert world.start.theta == pytest.approx(math.pi / 2)
    assert world.clearance(world.start.x, world.start.y) > 0.5


def test_every_shipped_world_loads_by_name() -> None:
    assert {"wean_hall_6", "small_world"} <= set(shipped_worlds())
    for name in shipped_worlds():
        assert load_world(name).name == name


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("corridors: [", "not YAML"),
        ("- 1", "must be a mapping"),
        ("corridors: []\ncorridors: []", "line 2: the key 'corridors' is there twice"),
        ("corridors: []", "one connected floor"),
        ("corridors: [{name: a, width: 2, line: [[0, 0], [5, 0]]}]", "'start' must be"),
        ("corridors: [{name: a, line: [[0, 0], [5, 0]]}]", "'width' is missing"),
        (
            "corridors: [{name: a, width: wide, line: [[0, 0], [5, 0]]}]",
            "'a': width must be a number, not 'wide'",
        ),
        ("corridors: 5", "corridors must be a list, not 5"),
    ],
)
def test_a_broken_file_is_named_in_one_line(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "floor.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(WorldError, match=says) as raised:
        load_world(str(path))
    assert str(path) in str(raised.value)
    assert "\n" not in str(raised.value)


def test_the_formats_page_names_every_key_and_its_example_is_a_world(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "floor_plans.md").read_text(encoding="utf-8")
    keys = (*floor_plan.KEYS, *floor_plan.CORRIDOR_KEYS, *floor_plan.FEATURE_KEYS, *floor_plan.START_KEYS)
    assert [key for key in keys if f"`{key}`" not in page] == []
    (tmp_path / "example.yaml").write_text(page.partition("```yaml\n")[2].partition("```")[0], encoding="utf-8")
    world = load_world(str(tmp_path / "example.yaml"))
    assert world.name == "corner"
    assert world.free_space.contains(shapely.Point(21.0, 17.0)), "the room is joined to the corridor's end"
    assert not world.free_space.contains(shapely.Point(23.8, 14.3))


def test_an_unknown_world_lists_the_known_ones() -> None:
    with pytest.raises(WorldError, match="wean_hall_6"):
        load_world("wean_hall_7")


def test_a_landmark_density_out_of_range_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "floor.yaml"
    path.write_text(
        "corridors: [{name: a, width: 2, line: [[0, 0], [5, 0]]}]\nstart: {x: 1, y: 0, heading_deg: 0}\n"
        "landmarks: {per_metre: 50.0}\n",
        encoding="utf-8",
    )
    with pytest.raises(WorldError, match="per_metre"):
        load_world(str(path))
