"""Where the robot is put, if not at the world's start."""

import pytest

from hslam_sim.run_configuration import RunConfiguration
from hslam_types.errors import ConfigurationError
from hslam_types.se2 import SE2


def test_a_start_is_three_numbers_or_the_worlds_own() -> None:
    assert RunConfiguration().start_in_world is None
    assert RunConfiguration(start="1.5 -2 0.25").start_in_world == SE2(1.5, -2.0, 0.25)


@pytest.mark.parametrize("start", ["1 2", "1 2 3 4", "here", "1,2,3"])
def test_a_start_that_is_no_pose_is_refused(start: str) -> None:
    with pytest.raises(ConfigurationError, match="must be x y heading"):
        _ = RunConfiguration(start=start).start_in_world
