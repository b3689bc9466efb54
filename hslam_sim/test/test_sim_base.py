"""The base moves as its wheels allow, drifts as the paper's did, and stops at walls."""

import math

import numpy as np
import pytest
import shapely

from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.scout_base import ScoutBase
from hslam_sim.wall_index import WallIndex
from hslam_sim.world import World
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity

STEP_S = 0.12
EXACT = BaseConfiguration().noise_free()
AHEAD = Velocity(0.4, 0.0)


def base_in(space: shapely.Polygon, config: BaseConfiguration, seed: int = 0, start: SE2 | None = None) -> ScoutBase:
    """Return a base at rest at the origin unless told otherwise."""
    start = start or SE2()
    walls = WallIndex(World("test", space, start, np.empty((0, 2))).walls, 7.0)
    return ScoutBase(start, walls, config, np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1]))


def plain(config: BaseConfiguration, seed: int = 0) -> ScoutBase:
    """Return a base in a plain too wide to meet a wall."""
    return base_in(shapely.box(-900, -900, 900, 900), config, seed)


def test_without_noise_the_encoders_tell_the_truth() -> None:
    """Odometry and true pose agree along a winding drive."""
    base = plain(EXACT)
    for i in range(500):
        base.step(Velocity(0.4, 0.8 * math.sin(0.05 * i)), STEP_S)
    assert base.encoder_pose == pytest.approx(base.true_pose, abs=1e-12)
    assert base.travelled_m > 20.0


def test_the_wheels_take_their_time() -> None:
    """Speed grows by the acceleration limit and no faster, and never beyond a wheel's limit."""
    base = plain(EXACT)
    base.step(Velocity(3.0, 0.0), STEP_S)
    assert base.velocity.forward == pytest.approx(EXACT.wheel_acceleration * STEP_S)
    for _ in range(20):
        base.step(Velocity(3.0, 0.0), STEP_S)
    assert base.velocity.forward == pytest.approx(EXACT.wheel_speed_limit)


def test_silence_stops_the_base() -> None:
    """Half a second without a command is driven on, then the wheels brake to rest."""
    base = plain(EXACT)
    for _ in range(10):
        base.step(AHEAD, STEP_S)
    # The last command's own step counts: four steps are 0.48 s.
    for _ in range(3):
        base.step(None, STEP_S)
    assert base.velocity.forward == pytest.approx(0.4)
    for _ in range(5):
        base.step(None, STEP_S)
    assert base.velocity == Velocity(0.0, 0.0)


def test_the_heading_drifts_by_the_run_s_bias() -> None:
    """The true heading leaves the odometry's by half to two degrees a metre, both ways over the seeds."""
    config = BaseConfiguration()
    drifts = []
    for seed in range(12):
        base = plain(config, seed)
        for _ in range(1000):
            base.step(AHEAD, STEP_S)
        assert base.encoder_pose.theta == 0.0
        # Unwrapped by the bias itself; what is left is the random walk over 48 m.
        rest = wrap(base.true_pose.theta - base.rotation_bias * base.travelled_m)
        assert abs(rest) < 4.0 * config.heading_walk * math.sqrt(base.travelled_m) + 0.02
        drifts.append(base.rotation_bias)
    assert all(config.bias_least <= abs(drift) <= config.bias_most for drift in drifts)
    assert min(drifts) < 0.0 < max(drifts)


def test_slip_has_its_stated_size() -> None:
    """A step's true length scatters by three per cent, its heading by the walk."""
    config = BaseConfiguration(bias_least=0.0, bias_most=0.0)
    base = plain(config)
    for _ in range(10):
        base.step(AHEAD, STEP_S)
    lengths, turns = [], []
    for _ in range(3000):
        before = base.true_pose
        base.step(AHEAD, STEP_S)
        lengths.append(math.dist(before[:2], base.true_pose[:2]))
        turns.append(wrap(base.true_pose.theta - before.theta))
    step_m = 0.4 * STEP_S
    assert np.std(lengths) == pytest.approx(0.03 * step_m, rel=0.05)
    assert np.std(turns) == pytest.approx(config.heading_walk * math.sqrt(step_m), rel=0.05)
    assert np.mean(lengths) == pytest.approx(step_m, rel=0.003)


def test_a_wall_stops_the_body_and_counts_once_a_contact() -> None:
    """The body never enters the wall, may turn and back off, and meets it anew afterwards."""
    room = shapely.box(-1, -1, 1, 1)
    base = base_in(room, EXACT)
    for _ in range(40):
        base.step(AHEAD, STEP_S)
        assert base.true_pose.x <= 1.0 - EXACT.body_radius_m + 1e-9
    held = base.touching
    assert held
    assert base.contacts == 1
    assert base.true_pose.x == pytest.approx(1.0 - EXACT.body_radius_m, abs=0.02)
    # The encoders stall with the wheels.
    assert base.encoder_pose.x == pytest.approx(base.true_pose.x, abs=0.02)
    for _ in range(10):
        base.step(Velocity(-0.2, 0.0), STEP_S)
    assert not base.touching
    assert base.true_pose.x < 0.7
    for _ in range(40):
        base.step(AHEAD, STEP_S)
    assert base.contacts == 2


@pytest.mark.parametrize("seed", range(3))
def test_no_drive_however_wild_enters_a_wall(seed: int) -> None:
    """Under random commands the clearance stays at the body's radius or more."""
    space = shapely.Polygon([(0, 0), (3, 0), (3, 1), (1.5, 1.2), (1.5, 3), (0, 3)])
    base = base_in(space, BaseConfiguration(), seed, SE2(0.5, 0.5, 0.0))
    rng = np.random.default_rng(seed)
    lowest = math.inf
    for _ in range(400):
        base.step(Velocity(rng.uniform(-1, 1), rng.uniform(-3, 3)), STEP_S)
        lowest = min(lowest, space.boundary.distance(shapely.Point(base.true_pose[:2])))
    assert lowest >= EXACT.body_radius_m - 1e-9
    assert base.contacts > 0


def test_poses_inside_a_step_lie_on_its_way() -> None:
    """Half-way through a straight step at full speed the base is half-way along."""
    base = plain(EXACT)
    for _ in range(10):
        base.step(AHEAD, STEP_S)
    end = base.true_pose
    for share in (0.0, 0.25, 0.4, 1.0):
        expected = end.x - (1.0 - share) * 0.4 * STEP_S
        assert base.true_pose_at(share * STEP_S).x == pytest.approx(expected, abs=1e-12)
