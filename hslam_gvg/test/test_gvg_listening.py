"""Listening turns: to either side, and back to where it began, so that odometry's errors cancel."""

import math

import pytest

from hslam_gvg.driving.handled import Handled
from hslam_gvg.driving.listening import listening
from hslam_gvg.driving.now import Now
from hslam_gvg.driving.surroundings import Surroundings
from hslam_gvg.driving.traversal import Traversal
from hslam_gvg.follow_config import FollowConfig, RingFollowConfig
from hslam_gvg.guards.ring_guard import RingGuardConfig
from hslam_gvg.local_graph.graph_config import RingGraphConfig
from hslam_gvg.ranging.sonar_map import SonarMap
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_types.se2 import SE2


def now_of(config: FollowConfig) -> Now:
    """Return a step in the middle of nothing."""
    local_map = SonarMap(SonarMapConfig(), RingGuardConfig(), config.body_m)
    around = Surroundings(config, local_map, RingGraphConfig())
    around.move(SE2())
    return Now(0, around, Traversal(), Handled(), config)


def test_the_turn_goes_to_either_side_and_ends_where_it_began() -> None:
    now = now_of(RingFollowConfig())
    heading, headings = 0.0, []
    for _ in range(200):
        command = listening(0.0, now)
        if command is None:
            break
        assert command.forward == 0.0
        heading += 0.02 * math.copysign(1.0, command.turn)
        headings.append(heading)
        now.around.move(SE2(0.0, 0.0, heading))
    assert heading == pytest.approx(0.0, abs=0.05)
    side = RingFollowConfig().listening_turn
    assert (min(headings), max(headings)) == pytest.approx((-side, side), abs=0.05)


def test_a_scanner_needs_no_turn() -> None:
    assert listening(0.0, now_of(FollowConfig())) is None
