"""The mission to navigate, against scripted levels."""

import math

import pytest
from scripted_level import ScriptedLevel, located, row

from hslam_atlas.missions.approach import Approach
from hslam_atlas.missions.destination import AtNode, DestinationError, OnEdge, ends_of, from_map, otherwise
from hslam_atlas.missions.mission import Happened, Sense
from hslam_atlas.missions.navigate import Navigate, Progress
from hslam_atlas.state import AtlasState
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.se2 import SE2

MIDDLE = (math.pi, 0.0, 1.5)


def at_node_one() -> tuple[Navigate, ScriptedLevel, AtlasState]:
    """A robot that has driven corridor 0 to node 1, on its way to node 2."""
    state = row()
    mission, level = Navigate(state, located(state)), ScriptedLevel()
    mission.go_to(AtNode(2))
    mission.step(level.departs((0.0,), 0, 0.0))
    return mission, level, state


def test_the_shortest_way_is_driven_node_by_node() -> None:
    mission, level, _ = at_node_one()
    decided = mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    assert decided.goal == GvgGoal(GoalKind.TRACE, branch=1)
    mission.step(level.departs(MIDDLE, 1, 12.0))
    decided = mission.step(level.arrives((math.pi,), 0, 24.0, seed=1))
    assert (decided.goal, decided.finished) == (None, True)
    assert mission.progress is Progress.REACHED


def test_a_lost_robot_reaches_the_graph_first() -> None:
    mission = Navigate(row())
    mission.go_to(AtNode(2))
    assert mission.step(Happened()).goal == GvgGoal(GoalKind.ACCESS)


def test_a_point_beside_the_edge_is_left_for_where_it_is_nearest() -> None:
    mission, level, _ = at_node_one()
    mission.go_to(OnEdge(1, 6.0, 0.7))
    mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    mission.step(level.departs(MIDDLE, 1, 12.0))
    for x in (4.0, 5.5, 6.0):
        assert mission.step(Happened(sense=level.sense(SE2(12.0 + x, 0.0, 0.0), SE2(x, 0.0, 0.0)))).goal is None
    sense = level.sense(SE2(18.3, 0.0, 0.0), SE2(6.3, 0.0, 0.0))
    goal = mission.step(Happened(sense=sense)).goal
    assert goal is not None
    assert goal.kind is GoalKind.STRAIGHT
    assert math.dist((goal.x_in_odom, goal.y_in_odom), (18.0, 0.7)) < 0.05
    mission.step(level.loses_its_way(sense))  # that is how a traversal ends that is left
    for _ in range(6):
        decided = mission.step(Happened(sense=level.sense(SE2(18.0, 0.65, 1.0), None, idle=True)))
    assert (mission.progress, decided.finished) == (Progress.REACHED, True)


def test_a_straight_drive_that_ends_before_its_point_is_tried_again_and_then_given_up() -> None:
    mission, level, _ = at_node_one()
    mission.go_to(OnEdge(1, 0.5, 0.7))
    goal = mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0)).goal
    assert goal is not None
    assert goal.kind is GoalKind.STRAIGHT
    short = level.sense(SE2(12.2, 0.2, 0.0), None, idle=True)
    goals = [mission.step(Happened(sense=short)).goal for _ in range(12)]
    assert [again for again in goals if again is not None] == [goal, GvgGoal(GoalKind.ACCESS)]
    assert mission.progress is Progress.UNDER_WAY


def test_an_unreachable_node_is_named_as_such() -> None:
    mission, level, state = at_node_one()
    mission.closed.add(1)
    decided = mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    assert decided.finished
    assert mission.progress is Progress.UNREACHABLE
    assert mission.why == "no way leads there from node 1; blocked: edges 1"
    assert state.graph.edges.keys() == {0, 1}


def test_a_new_errand_takes_the_place_of_the_last() -> None:
    mission, level, _ = at_node_one()
    mission.go_to(AtNode(0))
    goal = mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0)).goal
    assert goal == GvgGoal(GoalKind.TRACE, branch=0)


@pytest.mark.parametrize(
    ("destination", "why"),
    [(AtNode(9), "no node 9"), (OnEdge(7, 0.0, 0.0), "no edge 7"), (OnEdge(0, math.nan, 0.0), "finite")],
)
def test_what_is_nowhere_is_refused(destination: AtNode | OnEdge, why: str) -> None:
    with pytest.raises(DestinationError, match=why):
        Navigate(row()).go_to(destination)


def test_a_refused_goal_is_followed_by_reaching_the_graph() -> None:
    mission, level, _ = at_node_one()
    mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    mission.refused()
    assert mission.step(Happened(sense=Sense())).goal == GvgGoal(GoalKind.ACCESS)


def test_a_point_on_an_edge_is_one_point_from_either_end() -> None:
    near, far = ends_of(row().graph, OnEdge(1, 3.0, 0.5))
    assert (near.node, near.branch, near.along_m) == (1, 1, 3.0)
    assert near.in_node == pytest.approx((3.0, 0.5))
    assert (far.node, far.branch, far.along_m) == (2, 0, 9.0)
    assert far.in_node == pytest.approx((-9.0, 0.5))


def test_a_point_of_the_map_goes_to_the_edge_it_lies_beside() -> None:
    state = row()
    found = from_map(state.graph, state.maps, 15.0, 0.5)
    assert (found.edge, found.distance, found.offset) == pytest.approx((1, 3.0, 0.5))
    (other,) = otherwise(state.graph, state.maps, OnEdge(1, 0.5, 0.5))
    assert (other.edge, other.distance, other.offset) == pytest.approx((0, 12.5, 0.5))
    with pytest.raises(DestinationError, match="knows nothing about"):
        from_map(state.graph, state.maps, 15.0, 50.0)


def test_a_point_out_of_reach_is_not_left_for() -> None:
    far = Approach()
    assert not any(far.is_time(distance, room_m=1.0) for distance in (3.0, 2.0, 1.5, 1.6, 1.7))
    near = Approach()
    assert [near.is_time(d, room_m=1.0) for d in (1.2, 0.9, 0.8, 0.82, 0.84)] == [False] * 4 + [True]


def test_an_edge_driven_in_vain_is_followed_by_those_that_meet_it() -> None:
    """The point, 3 m aside, is given as one beside corridor 1; only corridor 0 is left to try."""
    mission, level, _ = at_node_one()
    mission.go_to(OnEdge(1, 0.5, 3.0))
    mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    mission.step(level.departs(MIDDLE, 1, 12.0))
    goal = mission.step(level.arrives((math.pi,), 0, 24.0, seed=1)).goal
    assert goal == GvgGoal(GoalKind.TRACE, branch=0)
    mission.step(level.departs((math.pi,), 0, 24.0))
    assert mission.progress is Progress.UNDER_WAY
    for _ in range(3):
        mission._count_a_try("in vain")
    assert (mission.progress, mission.why) == (Progress.UNREACHABLE, "in vain")


def test_a_loss_is_followed_by_reaching_the_graph() -> None:
    mission, level, _ = at_node_one()
    goal = mission.step(Happened((GvgEvent(9, 9, EventKind.LOST),), sense=level.sense(SE2(), None))).goal
    assert goal == GvgGoal(GoalKind.ACCESS)
