"""Where the way that was followed has ended, another one is taken: from how far off, and how often."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from drawn_walls import points_of

from hslam_gvg.driving import follow
from hslam_gvg.driving.doing import Following, Idle
from hslam_gvg.driving.handled import Handled
from hslam_gvg.driving.now import Step
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_gvg.local_graph.local_graph import local_graph
from hslam_types.se2 import SE2
from hslam_types.sensing import Velocity

OLD = np.array([[0.0, 0.75, 1.0], [0.1, 0.75, 1.0]])
"""The rest of the path that was followed, aside of the graph."""


def now(y: float = 0.75, *, clear: bool = True, driven_m: float = 0.0) -> Any:
    """Return a step of a robot in a corridor along x, at ``y`` beside its middle, where the graph is."""
    walls = points_of(((-6, 1.0, 6, 1.0), (-6, -1.0, 6, -1.0)), step_m=0.1)
    graph = local_graph(walls, lambda _, y: np.abs(y) < 1.0, 0.0, 0.0, LocalGraphConfig())
    around = SimpleNamespace(
        graph=graph, pose=SE2(0.0, y, 0.0), travel_m=0.0, line_is_clear=lambda *_: clear, clearance=lambda *_: 0.25,
        look=lambda: None,
    )  # fmt: skip
    traversal = SimpleNamespace(length_m=driven_m, leg=None, back=lambda *_: np.zeros((0, 3)))
    return SimpleNamespace(
        around=around, traversal=traversal, handled=Handled(), stamp_ns=0, config=SimpleNamespace(listening_turn=0.0)
    )


def test_a_robot_that_strayed_takes_the_graph_s_way_from_where_it_is() -> None:
    way = follow._another_way(Following(OLD, None, is_exit=False, anew=1), now(driven_m=4.0))
    assert way is not None
    assert way.path[0].tolist() == [0.0, 0.75, 0.25]
    assert np.abs(way.path[1:, 1]).max() < 0.1
    assert math.dist(way.path[-1, :2], (0.0, 0.0)) > 1.0
    assert (way.anew, way.anew_m) == (2, 4.0)


def test_but_not_through_a_wall_unless_it_is_as_good_as_on_it() -> None:
    doing = Following(OLD, None, is_exit=False)
    assert follow._another_way(doing, now(clear=False)) is None
    assert follow._another_way(doing, now(0.5, clear=False)) is not None


@pytest.mark.parametrize(("driven_m", "again"), [(5.9, False), (6.1, True)])
def test_after_six_metres_other_ways_may_be_taken_as_often_again(
    driven_m: float, again: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = Following(OLD, None, is_exit=False)
    monkeypatch.setattr(follow, "_another_way", lambda *_: other)
    monkeypatch.setattr(follow, "_arrived_at_end", lambda *_: Step(Velocity(), Idle()))
    worn = Following(OLD, None, is_exit=False, anew=follow.ANEW)
    assert (follow._at_end(worn, now(driven_m=driven_m)).then is other) == again
