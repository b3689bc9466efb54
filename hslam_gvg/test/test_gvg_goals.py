"""What can be asked of the GVG level, and what becomes of a goal that cannot be carried out."""

import math

import pytest

from hslam_gvg.server import GvgError, GvgServer
from hslam_types.gvg_events import GoalKind, GvgGoal


@pytest.mark.parametrize("target", [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf)])
def test_a_target_that_is_no_point_is_refused(target: tuple[float, float]) -> None:
    server = GvgServer()
    with pytest.raises(GvgError, match="finite"):
        server.start(GvgGoal(GoalKind.STRAIGHT, x_in_odom=target[0], y_in_odom=target[1]))
    assert server.next_goal is None
