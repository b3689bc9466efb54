"""The mission to explore, against a scripted GVG level."""

import math

import pytest

from hslam_atlas.config import AtlasConfig
from hslam_atlas.missions.explore import Explore
from hslam_atlas.missions.mission import Decision, Happened
from hslam_atlas.server import AtlasServer
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind, NodeView

VIEW = NodeView(NodeKind.MEET_POINT, 0.0, 0.0, 1.2, (0.0, 2.0, -2.0))


def server() -> AtlasServer:
    return AtlasServer(AtlasConfig(mission="explore"))


def test_the_first_goal_is_to_reach_the_graph_and_is_given_once() -> None:
    atlas = server()
    assert atlas.step((), (), ()).goal == GvgGoal(GoalKind.ACCESS)
    assert atlas.step((), (), ()).goal is None


@pytest.mark.parametrize("kind", [EventKind.ARRIVAL, EventKind.LOST])
def test_what_ends_a_traversal_asks_for_the_next_goal(kind: EventKind) -> None:
    atlas = server()
    atlas.step((), (), ())
    node = VIEW if kind is EventKind.ARRIVAL else None
    goal = atlas.step((GvgEvent(0, 1, kind, node, 0),), (), ()).goal
    assert goal is not None
    assert goal.kind is (GoalKind.TRACE if node else GoalKind.ACCESS)


@pytest.mark.parametrize("kind", [EventKind.ACCESS, EventKind.DEPARTURE])
def test_what_begins_a_traversal_asks_for_none(kind: EventKind) -> None:
    atlas = server()
    atlas.step((), (), ())
    assert atlas.step((GvgEvent(0, 1, kind, VIEW, 0),), (), ()).goal is None


def test_a_goal_refused_is_followed_by_reaching_the_graph_anew() -> None:
    atlas = server()
    atlas.step((), (), ())
    atlas.step((GvgEvent(0, 1, EventKind.ARRIVAL, VIEW, 0),), (), ())
    atlas.refused()
    assert atlas.step((), (), ()).goal == GvgGoal(GoalKind.ACCESS)


def test_the_mission_taken_up_on_the_way_waits_for_its_end() -> None:
    atlas = AtlasServer(AtlasConfig(mission="none"))
    atlas.step((GvgEvent(0, 1, EventKind.DEPARTURE, VIEW, 1),), (), ())
    atlas.explore()
    assert atlas.step((), (), ()).goal is None
    goal = atlas.step((GvgEvent(1, 2, EventKind.LOST),), (), ()).goal
    assert goal == GvgGoal(GoalKind.ACCESS)


def test_nothing_left_within_reach_ends_it_until_something_happens() -> None:
    atlas = server()
    atlas.step((), (), ())
    atlas.step((GvgEvent(0, 1, EventKind.ARRIVAL, VIEW, 0),), (), ())
    for branch in atlas.state.graph.nodes[0].branches.values():
        branch.given_up = True
    mission = Explore(atlas.state, atlas.questions, atlas.mapper)
    assert mission.step(Happened()) == Decision(GvgGoal(GoalKind.STOP), finished=True)
    assert mission.step(Happened()) == Decision(None, finished=True)
    assert not mission.step(Happened((GvgEvent(1, 2, EventKind.ACCESS),))).finished


def test_without_a_mission_the_robot_is_asked_nothing() -> None:
    atlas = server()
    atlas.stop()
    arrived = atlas.step((GvgEvent(0, 1, EventKind.ARRIVAL, VIEW, 0),), (), ())
    assert arrived.goal is None
    assert arrived.changed
    assert math.isclose(atlas.state.graph.nodes[0].clearance_m, 1.2)
