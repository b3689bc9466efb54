"""Known answers of the locator off the graph, before what blocks an edge, and among several places."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scripted_level import EXACT, LENGTH_M, ScriptedLevel, edge_map, located, row

from hslam_atlas.config import AtlasConfig
from hslam_atlas.localisation.anywhere import about_a_node
from hslam_atlas.localisation.locator import Locator, _distinct
from hslam_atlas.localisation.on_edge import base_on_edge
from hslam_atlas.localisation.place import Place, beyond_doubt
from hslam_atlas.missions.mission import Happened
from hslam_atlas.missions.navigate import Navigate
from hslam_atlas.sighting import sight_of
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2

MIDDLE = (math.pi, 0.0, 1.5)


def so_far(traversal: int, along_m: float, seed: int = 0, heading: float = 0.0) -> EdgeMap:
    """Return the map of a corridor driven as far as a place, the robot turned by ``heading`` there."""
    full = edge_map(traversal, seed)
    kept = np.flatnonzero(full.landmarks[:, 0] < along_m + 3.0)
    size = 2 + 2 * len(kept)
    covariance = 1e-4 * np.eye(size)
    covariance[1, 1] = 0.0
    return replace(
        full, terminal_x=along_m, landmarks=full.landmarks[kept], covariance=covariance, sightings=(9,) * len(kept),
        path_length_m=along_m, robot_at_arrival=SE2(along_m, 0.0, heading),
    )  # fmt: skip


def stops(level: ScriptedLevel, along_m: float, *, bearings: tuple[float, ...] = (math.pi,), seed: int = 0) -> Happened:
    """Return an arrival midway along a corridor."""
    kind = NodeKind.BOUNDARY_POINT if len(bearings) == 1 else NodeKind.MEET_POINT
    view = NodeView(kind, along_m, 0.0, 1.0, bearings)
    level.sequence += 1
    event = GvgEvent(level.sequence, level.sequence, EventKind.ARRIVAL, view, 0, along_m)
    drive = replace(so_far(level.traversal, along_m, seed), arrival=event.sequence)
    base = SE2(along_m, 0.0, 0.0)
    return Happened((event,), (drive,), sense=level.sense(base, base))


def on_its_way() -> tuple[Locator, ScriptedLevel]:
    """Return a locator of a robot that has left node 0 along corridor 0."""
    locator, level = located(row()), ScriptedLevel()
    locator.hear(level.departs((0.0,), 0, 0.0))
    return locator, level


def test_stopped_short_of_its_node_the_robot_is_on_the_edge_and_that_is_blocked() -> None:
    locator, level = on_its_way()
    heard = stops(level, 6.0)
    locator.hear(heard)
    assert locator.blocked == 0
    place = locator.certain
    assert place is not None
    assert place.node == 0
    assert place.base_in_node(heard.sense) == pytest.approx((6.0, 0.0, 0.0), abs=0.05)


@pytest.mark.parametrize(
    ("along_m", "bearings", "seed"), [(6.0, MIDDLE, 0), (6.0, (math.pi,), 77), (LENGTH_M + 4.0, (math.pi,), 0)]
)
def test_a_node_another_corridor_or_a_longer_way_is_no_blocked_edge(
    along_m: float, bearings: tuple[float, ...], seed: int
) -> None:
    locator, level = on_its_way()
    locator.hear(stops(level, along_m, bearings=bearings, seed=seed))
    assert locator.blocked is None


def test_a_blocked_edge_is_closed_to_an_errand() -> None:
    state = row()
    mission, level = Navigate(state, located(state)), ScriptedLevel()
    mission.step(level.departs((0.0,), 0, 0.0))
    mission.step(stops(level, 6.0))
    assert mission.closed == {0}


def test_back_on_the_graph_the_place_is_where_odometry_has_led() -> None:
    locator, level = on_its_way()
    locator.leave(level.sense(SE2(6.0, 0.0, 0.0), SE2(6.0, 0.0, 0.0)))
    access = GvgEvent(40, 40, EventKind.ACCESS)
    level.traversal = 40
    locator.hear(Happened((access,), sense=level.sense(SE2(6.0, 0.8, 1.0), SE2())))
    place = locator.certain
    assert place is not None
    assert place.base_in_node(level.sense(SE2(), SE2(0.3, 0.0, 0.0))) == pytest.approx(
        SE2(6.0, 0.8, 1.0) @ SE2(0.3, 0.0, 0.0)
    )


def test_on_an_edge_the_place_is_corrected_by_what_its_map_shows() -> None:
    """The robot is thought to be 0.2 m aside of where it is."""
    locator, level = on_its_way()
    off = UncertainPose.exact(SE2(0.1, 0.2, 0.02))
    locator.places = [replace(locator.places[0], frame_in_node=off)]
    here = SE2(6.0, 0.0, 0.0)
    sense = replace(level.sense(here, here), so_far=lambda _: so_far(level.traversal, 6.0))
    assert locator.correct(0, 0, sense)
    place = locator.certain
    assert place is not None
    assert place.base_in_node(sense) == pytest.approx(here, abs=0.05)
    assert not locator.correct(1, 0, sense)  # an edge of another node


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.5])
def test_where_on_an_edge_the_robot_is_and_how_it_faces(heading: float) -> None:
    truth = SE2(6.0, 0.0, heading)
    found = base_on_edge(edge_map(0, 0), so_far(9, 6.0, heading=heading), truth @ SE2(0.1, -0.1, 0.05), AtlasConfig())
    assert found is not None
    assert found.pose == pytest.approx(truth, abs=0.03)


def test_an_edge_that_shows_something_else_or_hardly_anything_tells_no_place() -> None:
    here, config = SE2(6.0, 0.0, 0.0), AtlasConfig()
    assert base_on_edge(edge_map(0, 77), so_far(9, 6.0), here, config) is None
    full = edge_map(0, 0)
    near = np.argsort(np.hypot(full.landmarks[:, 0] - 6.0, full.landmarks[:, 1]))[:5]
    few = replace(full, landmarks=full.landmarks[near], sightings=(9,) * 5, covariance=1e-4 * np.eye(12))
    assert base_on_edge(few, so_far(9, 6.0), here, config) is None
    assert base_on_edge(few, so_far(9, 6.0), here, replace(config, least_fraction=0.1)) is not None


def test_the_end_of_a_drive_from_somewhere_on_an_edge_tells_the_node_and_how_it_lies() -> None:
    """Begun 4 m along corridor 0, come to node 1, where its branch leaves by 0.2 rad beside the edge's x axis."""
    state = row()
    state.graph.nodes[1].branches[0].bearing = math.pi - 0.2
    drive = so_far(9, LENGTH_M)
    ahead = np.flatnonzero(drive.landmarks[:, 0] > 2.0)
    moved = replace(
        so_far(9, 8.0), landmarks=drive.landmarks[ahead] - [4.0, 0.0], sightings=(9,) * len(ahead),
        covariance=np.diag([1e-4, 0.0] + [1e-4] * (2 * len(ahead))), arrival_heading=math.pi - 0.2,
    )  # fmt: skip
    view = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, tuple(bearing + 0.5 for bearing in MIDDLE))
    sight = sight_of(GvgEvent(9, 9, EventKind.ARRIVAL, view, 0, 8.0), moved)
    best = max(about_a_node(state, moved, sight), key=lambda place: place.evidence)
    assert (best.node, best.keys, best.come) == (1, (0, 1, 2), 0)
    assert best.frame_in_node.pose == pytest.approx(SE2(-8.0, 0.0, 0.0), abs=0.05)
    most = state.look_alikes.capped(1000.0) - math.log(4.0) + 0.5  # one of four ends of edges; the view fits
    assert best.evidence == pytest.approx(most, abs=0.1)


def test_one_place_alone_needs_the_lead_as_well() -> None:
    place = Place(0, EXACT, 1, 10.0)
    assert beyond_doubt([place], AtlasConfig(close_evidence=9.0, close_margin=9.0)) is place
    assert beyond_doubt([place], AtlasConfig(close_evidence=9.0, close_margin=11.0)) is None


def test_of_each_node_and_branch_come_by_the_likeliest_place_is_kept() -> None:
    by_west, again, by_east = (Place(1, EXACT, 1, e, (0, 1), come) for e, come in ((3.0, 0), (5.0, 0), (4.0, 1)))
    unlikely = Place(2, EXACT, 1, -3.1)
    assert _distinct([by_west, again, by_east, unlikely]) == [again, by_east]


def test_no_belief_is_so_strong_that_a_robot_cannot_have_been_carried_away() -> None:
    locator, level = on_its_way()
    locator.places = [replace(locator.places[0], evidence=29.0)]
    locator.hear(level.arrives(MIDDLE, 0, 12.0, seed=0))
    assert locator.places[0].evidence == pytest.approx(30.5)  # 30, and the view's half nat on top
