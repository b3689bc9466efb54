"""Off the graph: a robot that strayed goes back on it, and one that cannot get back to its node does not say it did."""

import math

import numpy as np
from drawn_walls import points_of

from hslam_gvg.driving.continuity import ways_at
from hslam_gvg.driving.doing import Homing, Idle
from hslam_gvg.driving.handled import Handled
from hslam_gvg.driving.home import home
from hslam_gvg.driving.now import Now
from hslam_gvg.driving.surroundings import Surroundings
from hslam_gvg.driving.traversal import Leg, Traversal
from hslam_gvg.follow_config import RingFollowConfig
from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.local_graph import local_graph
from hslam_gvg.ranging.sonar_map import SonarMap
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_types.gvg_events import EventKind, NodeKind, NodeView
from hslam_types.se2 import SE2

NODE = NodeView(NodeKind.MEET_POINT, 3.0, 0.0, 1.0, (0.0, 2.0, 4.0))


def returned_to(x: float) -> Traversal:
    """Return the edge under way after the robot gave up its way back to the node at a place short of it."""
    config, traversal = RingFollowConfig(listening_turn=0.0), Traversal()
    around = Surroundings(config, SonarMap(SonarMapConfig(), RingGuardConfig(), config.body_m), LocalGraphConfig())
    around.move(SE2(x, 0.0, 0.0))
    traversal.begin_step(0)
    traversal.depart(Leg(NODE, 1, (np.zeros((2, 3)),) * 3))
    traversal.begin_step(1)
    doing = Homing(3.0, 0.0, 1.0, is_end=False, since_ns=0, onward=np.zeros((1, 3)), returned=True, stood=3)
    assert isinstance(home(doing, Now(10, around, traversal, Handled(), config)).then, Idle)
    return traversal


def test_a_way_back_that_ends_at_the_node_is_an_arrival_there() -> None:
    assert [event.kind for event in returned_to(2.5).events] == [EventKind.ARRIVAL]


def test_a_way_back_that_ends_elsewhere_is_a_loss() -> None:
    assert [event.kind for event in returned_to(0.0).events] == [EventKind.LOST]


def test_a_branch_is_in_reach_of_a_robot_that_strayed() -> None:
    walls = points_of(((-6, 1.0, 6, 1.0), (-6, -1.0, 6, -1.0)), step_m=0.1)
    graph = local_graph(walls, lambda _, y: np.abs(y) < 1.0, 0.0, 0.0, LocalGraphConfig())
    assert graph is not None
    strayed = SE2(0.0, 0.75, math.pi / 2)
    assert not list(ways_at(graph, strayed, Handled(), 0.0))
    assert list(ways_at(graph, strayed, Handled(), 0.0, 1.5))
