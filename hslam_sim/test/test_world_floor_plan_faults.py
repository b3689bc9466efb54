"""Whatever is in a floor plan, it is a world or one line that names the file and the key."""

import contextlib
import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hslam_sim.simulation import Simulation, SimulationConfiguration
from hslam_sim.world import World, WorldError
from hslam_sim.worlds import load_world

PLAN: dict[str, Any] = {
    "name": "office",
    "features": {
        "door": {"shape": "recess", "width": 1.0, "depth": 0.2},
        "pilaster": {"shape": "pilaster", "width": 0.3, "depth": 0.25},
    },
    "corridors": [
        {"name": "main", "width": 2.0, "line": [[0, 0], [10, 0], [10, 8]], "left": {"door": [4.0], "pilaster": [6]}},
        {"width": 2.0, "line": [[0, 0], [-6, 0], [-6, 6], [0, 6]], "closed": True, "right": {"door": [3]}},
    ],
    "rooms": [[[10, 8], [14, 8], [14, 12], [10, 12]]],
    "obstacles": [[[12, 9], [13, 9], [13, 10]]],
    "landmarks": {"per_metre": 1.0, "least_gap_m": 0.6},
    "start": {"x": 1.0, "y": 0.0, "heading_deg": 90.0},
}
DIGITS = "9" * 400


def loaded(folder: Path, text: str) -> World:
    """Return the world of a YAML text."""
    path = folder / "floor.yaml"
    path.write_text(text, encoding="utf-8")
    return load_world(str(path))


def changed(place: tuple[str | int, ...], value: object) -> str:
    """Return the plan as YAML with another value at one place."""
    plan: Any = copy.deepcopy(PLAN)
    *to, last = place
    inner = plan
    for step in to:
        inner = inner[step]
    inner[last] = value
    return yaml.safe_dump(plan, sort_keys=False)


def test_the_plan_itself_is_a_world(tmp_path: Path) -> None:
    world = loaded(tmp_path, yaml.safe_dump(PLAN))
    assert world.name == "office"
    assert len(world.free_space.interiors) == 2


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (("rooms", 0), [[10, 8], [14, 12], [14, 8], [10, 12]], r"rooms\[0\] is no polygon: Self-intersection"),
        (("rooms", 0), [[10, 8], [14, 8]], r"rooms\[0\] must be a list of at least three corners"),
        (("rooms", 0, 2), [14, float("nan")], r"rooms\[0\]\[2\]\[1\] must be a number"),
        (("obstacles", 0), [[0, 0], [1, 0], [2, 0]], r"obstacles\[0\] is no polygon"),
        (("obstacles", 0), [[-99, -99], [99, -99], [99, 99], [-99, 99]], "less the obstacles,.* 0 parts"),
        (("obstacles", 0), [[5, -9], [6, -9], [6, 9], [5, 9]], "less the obstacles,.* 2 parts"),
        (("obstacles",), {"a": 1}, "obstacles must be a list"),
        (("corridors", 0, "width"), float("inf"), "corridor 'main': width must be a number"),
        (("corridors", 0, "width"), -2.0, "corridor 'main': width must be a number from 0"),
        (("corridors", 0, "width"), 0.37, "corridor 'main': width: 0.37 m is narrower than the body, 0.38 m"),
        (("corridors", 0, "width"), True, "corridor 'main': width must be a number"),
        (("corridors", 1, "width"), "wide", r"corridors\[1\]: width must be a number, not 'wide'"),
        (
            ("corridors", 0, "line", 1),
            [1e9, 0],
            r"corridor 'main': line\[1\]\[0\] must be a number from -10000",
        ),
        (("corridors", 0, "line", 1), [0, 0], r"corridor 'main': line has the point \[0.0, 0.0\] twice in a row"),
        (("corridors", 0, "line", 1), [0, 1e-38], r"corridor 'main': line has the point \[0.0, 0.0\] twice in a row"),
        (("corridors", 0, "line", 1), [1, 2, 3], r"corridor 'main': line\[1\] must be \[x, y\]"),
        (("corridors", 0, "line"), [], "corridor 'main': line must have at least two points"),
        (("corridors", 1, "line"), [[0, 0], [5, 0]], r"corridors\[1\]: line must have at least three points"),
        (("corridors", 1, "closed"), "yes", r"corridors\[1\]: closed must be true or false"),
        (("corridors", 0, "name"), "a\nb", r"corridors\[0\]: name: 'a\\nb' is no name"),
        (("corridors", 0, "left"), {"gate": [1]}, r"corridor 'main': left: gate\[0\]: there is no feature 'gate'"),
        (("corridors", 0, "left"), {"door": [-1]}, r"corridor 'main': left: door\[0\] must be a number from 0"),
        (("corridors", 0, "left"), {"door": 4}, "corridor 'main': left: door must be a list"),
        (("corridors", 0), 5, r"corridors\[0\] must be a mapping"),
        (("corridors", 0, "with"), 5, r"corridors\[0\]: unknown key 'with'; known are: .*width"),
        (("features", "door", "width"), -1.0, "features: door: width must be a number from 0.01"),
        (("features", "door", "depth"), 0.0, "features: door: depth must be a number from 0.01"),
        (("features", "door", "shape"), "hole", "features: door: shape must be recess or pilaster"),
        (("features", "door", "wide"), 1, "features: door: unknown key 'wide'"),
        (("features", "a\nb"), {}, r"features: 'a\\nb' is no name"),
        (("name",), "../../elsewhere", r"name: '../../elsewhere' is no name"),
        (("name",), "..", r"name: '..' is no name"),
        (("name",), "/etc/passwd", r"name: '/etc/passwd' is no name"),
        (("name",), 7, "name: 7 is no name"),
        (("landmarks", "per_metre"), float("nan"), "per_metre"),
        (("landmarks", "per_meter"), 1.0, "landmarks: unknown key 'per_meter'"),
        (("landmarks",), 5, "landmarks must be a mapping"),
        (("start", "x"), float("nan"), "start: x must be a number"),
        (("start", "heading_deg"), 1e9, "start: heading_deg must be a number from -360 to 360"),
        (("start", "y"), 0.9, "start: 0.10 m to the nearest wall; the body needs 0.19 m"),
        (("start", "y"), 40, "not in free space"),
        (("start", "z"), 0, "start: unknown key 'z'"),
        (("start",), None, "'start' must be a mapping"),
    ],
)
def test_what_cannot_be_meant_is_named(tmp_path: Path, place: tuple[str | int, ...], value: object, says: str) -> None:
    with pytest.raises(WorldError, match=says) as raised:
        loaded(tmp_path, changed(place, value))
    assert str(raised.value).startswith(f"{tmp_path / 'floor.yaml'}: ")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "text",
    [
        f"corridors: [{{width: {DIGITS}, line: [[0, 0], [5, 0]]}}]",
        f"corridors: [{{width: 2, line: [[0, 0], [5, {DIGITS}.0]]}}]",
        f"corridors: [{{width: 2, line: [[0, 0], [5, 1e{DIGITS}]]}}]",
        "corridors: &a [*a]",
        "a0: &a0 [1, 1]\n" + "".join(f"a{n + 1}: &a{n + 1} [*a{n}, *a{n}]\n" for n in range(40)),
        "a0: &a0 {x: 1}\n" + "".join(f"a{n + 1}: &a{n + 1} {{<<: [*a{n}, *a{n}]}}\n" for n in range(40)),
        "corridors: []\nrooms: []\ncorridors: []",
        "{}",
        "x" * 5_000_000,
    ],
)
def test_a_text_of_too_much_is_one_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(WorldError) as raised:
        loaded(tmp_path, text)
    assert str(tmp_path / "floor.yaml") in str(raised.value)
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) < 500


@pytest.mark.parametrize("name", ["~nobody_at_all/floor.yaml", "x" * 5000, "a\0b", "", "."])
def test_a_path_that_leads_nowhere_is_one_line(name: str) -> None:
    with pytest.raises(WorldError, match="no world"):
        load_world(name)


def test_a_larger_body_than_the_start_has_room_for_is_refused(tmp_path: Path) -> None:
    world = loaded(tmp_path, changed(("start", "y"), 0.75))
    Simulation(world)
    config = SimulationConfiguration()
    wide = SimulationConfiguration(base=type(config.base).from_mapping({"body_radius_m": 0.3}))
    with pytest.raises(WorldError, match=r"start: 0\.25 m to the nearest wall; the body needs 0\.3 m"):
        Simulation(world, wide)


def places(value: Any, here: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yield the place of every value within a plan."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, item in inner:
        yield (*here, step)
        yield from places(item, (*here, step))


ODD: st.SearchStrategy[object] = st.sampled_from(
    [None, True, "", "x", "nan", [], {}, [[]], [1], {"x": 1}, 0, -1, 1e9, -1e-9, 1e-300, 1e300, 0.5, 9.9e3]
) | st.floats(-20.0, 20.0).map(lambda value: round(value, 2)) | st.floats() | st.integers()  # fmt: skip


@settings(max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=st.lists(st.tuples(st.sampled_from(list(places(PLAN))), ODD, st.booleans()), min_size=1, max_size=4))
def test_a_plan_with_odd_values_is_a_world_or_one_line(
    tmp_path: Path, changes: list[tuple[tuple[str | int, ...], object, bool]]
) -> None:
    plan: Any = copy.deepcopy(PLAN)
    for (*to, last), value, drop in changes:
        with contextlib.suppress(KeyError, IndexError, TypeError):  # an earlier change may have taken the place
            inner: Any = plan
            for step in to:
                inner = inner[step]
            if drop:
                del inner[last]
            else:
                inner[last] = value
    try:
        world = loaded(tmp_path, yaml.safe_dump(plan))
    except WorldError as error:
        message = str(error)
    else:
        assert world.clearance(world.start.x, world.start.y) >= 0.19
        message = str(tmp_path / "floor.yaml")
    assert "\n" not in message
    assert str(tmp_path / "floor.yaml") in message
