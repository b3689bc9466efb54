"""The mission to navigate, against scripted levels."""

import math
from dataclasses import replace

import pytest
from scripted_level import ScriptedLevel, located, row

from hslam_atlas.localisation.place import Place
from hslam_atlas.missions.approach import Approach
from hslam_atlas.missions.destination import AtNode, DestinationError, OnEdge, ends_of, from_map, otherwise
from hslam_atlas.missions.localise import Localise
from hslam_atlas.missions.mission import Happened, Sense
from hslam_atlas.missions.navigate import Navigate, Progress
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind, NodeView
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
    again, then = [goal for goal in goals if goal is not None]
    assert again == goal
    assert then.kind is GoalKind.ACCESS  # by the edge that meets its own: back to node 1
    assert then.heading_in_odom == pytest.approx(-math.pi)
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
    assert goal is not None
    assert goal.kind is GoalKind.ACCESS


def test_the_ways_to_a_point_are_those_to_both_ends_of_its_edge_and_on_along_it() -> None:
    """3 m along corridor 1: at once from its first end, round by its other, or come back; 6 m for a stop at a node."""
    mission, _, _ = at_node_one()
    mission.go_to(OnEdge(1, 3.0, 0.5))
    assert sorted(mission._ways(1, (0, 1))) == [(3.0, 1), (27.0, 1), (39.0, 0)]
    assert sorted(mission._ways(0, (0,))) == [(21.0, 0), (45.0, 0)]


def test_the_fourth_try_in_vain_is_the_last() -> None:
    mission, _, _ = at_node_one()
    told = []
    for _ in range(4):
        mission._count_a_try("in vain")
        told.append(mission.progress)
    assert told == [Progress.UNDER_WAY] * 3 + [Progress.UNREACHABLE]


def test_a_clearance_read_too_small_by_its_error_keeps_nobody_from_a_point() -> None:
    near, far = Approach(), Approach()
    assert [near.is_time(d, room_m=1.0) for d in (1.2, 1.05, 1.09)] == [False, False, True]
    assert [far.is_time(d, room_m=1.0) for d in (1.2, 1.07, 1.11)] == [False] * 3


def test_a_point_is_one_place_in_the_node_where_two_edges_meet() -> None:
    """Each edge has its own frame there, turned and moved against the other's."""
    state = row()
    graph = state.graph
    for edge, end, frame in ((0, 1, SE2(0.1, 0.2, math.pi - 0.3)), (1, 0, SE2(-0.1, 0.1, 0.2))):
        ends = list(graph.edges[edge].ends)
        ends[end] = ends[end]._replace(frame_in_node=UncertainPose.exact(frame))
        graph.put_edge(replace(graph.edges[edge], ends=(ends[0], ends[1])))
    (other,) = otherwise(graph, state.maps, OnEdge(0, 11.0, 0.5))
    in_node = [end.in_node for point in (OnEdge(0, 11.0, 0.5), other) for end in ends_of(graph, point) if end.node == 1]
    assert in_node[0] == pytest.approx(in_node[1])


def test_of_two_edges_beside_a_point_the_one_that_sees_more_of_it_in_one_drive_is_taken() -> None:
    """Driven often an edge has seen everything often."""
    state = row()
    x = 11.0
    first = from_map(state.graph, state.maps, x, 0.5).edge
    often = state.maps.get(1 - first)
    state.maps.put(1 - first, replace(often, sightings=tuple(9 * n for n in often.sightings)))
    state.graph.put_edge(replace(state.graph.edges[1 - first], traversals=tuple(range(9))))
    assert from_map(state.graph, state.maps, x, 0.5).edge == first


def test_a_lost_robot_drives_on_by_known_edges_that_tell_its_places_apart() -> None:
    """Three branches in view, come by the first."""
    state = row()
    search = Localise(state)
    seen = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.0, (math.pi, 0.0, 1.5))
    arrival = GvgEvent(1, 1, EventKind.ARRIVAL, seen, 0, 12.0)
    frame = UncertainPose.exact(SE2())
    assert search.next_goal(arrival).branch == 1  # nothing known: not back
    search.locator.places = [Place(1, frame, 1, 3.0, (0, 2, 1), 0)]
    assert search.next_goal(arrival).branch == 2  # a known edge before an unexplored branch
    state.graph.put_edge(replace(state.graph.edges[1], path_length_m=20.0))
    search.locator.places = [Place(1, frame, 1, 3.0, (2, 0, 1), 0), Place(1, frame, 1, 2.0, (2, 0, 0), 0)]
    assert search.next_goal(arrival).branch == 2  # though longer: by the other both places lead 12 m


@pytest.mark.parametrize(("tolerance_m", "there"), [(0.05, False), (0.12, True)])
def test_a_point_is_reached_as_near_as_the_configuration_says(tolerance_m: float, there: bool) -> None:
    mission, level, state = at_node_one()
    state.config = replace(state.config, goal_tolerance_m=tolerance_m)
    mission.go_to(OnEdge(1, 0.5, 0.7))
    mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    beside = level.sense(SE2(12.5, 0.62, 0.0), None, idle=True)
    for _ in range(12):
        mission.step(Happened(sense=beside))
    assert (mission.progress is Progress.REACHED) == there


def test_near_its_point_the_robot_looks_at_the_edge_s_map_every_fourth_cycle(monkeypatch: pytest.MonkeyPatch) -> None:
    mission, level, _ = at_node_one()
    mission.go_to(OnEdge(1, 11.0, 0.7))
    mission.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    mission.step(level.departs(MIDDLE, 1, 12.0))
    looks: list[object] = []

    def correct(*arguments: object) -> bool:
        looks.append(arguments)
        return False

    monkeypatch.setattr(mission.locator, "correct", correct)
    for x in (1.0, 2.0, 3.0, 4.0):  # farther than 5 m from it
        mission.step(Happened(sense=level.sense(SE2(12.0 + x, 0.0, 0.0), SE2(x, 0.0, 0.0))))
    assert not looks
    for k in range(8):
        x = 6.5 + 0.1 * k
        mission.step(Happened(sense=level.sense(SE2(12.0 + x, 0.0, 0.0), SE2(x, 0.0, 0.0))))
    assert len(looks) == 2


@pytest.mark.parametrize(("branch", "end"), [(1, 0), (2, 1)])
def test_on_a_loop_the_branch_left_by_tells_its_ends_apart(branch: int, end: int) -> None:
    mission, _, state = at_node_one()
    first, second = state.graph.edges[1].ends
    loop = replace(state.graph.edges[1], ends=(first, second._replace(node=1, branch=2)))
    state.graph.put_edge(loop)
    mission._on = 1
    assert mission._end_at(Place(1, UncertainPose.exact(SE2()), 1, 9.0, branch=branch)) == end
