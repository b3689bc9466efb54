"""What the locator believes after drives along corridors of a small atlas."""

import math

from scripted_level import ScriptedLevel, located, row

from hslam_atlas.localisation.locator import Locator
from hslam_atlas.localisation.place import Place, beyond_doubt
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.se2 import SE2

MIDDLE = (math.pi, 0.0, 1.5)


def test_a_known_robot_is_followed_along_a_known_edge() -> None:
    locator, level = located(row()), ScriptedLevel()
    locator.hear(level.departs((0.0,), 0, 0.0))
    assert locator.certain is not None
    assert locator.certain.branch == 0
    locator.hear(level.arrives(MIDDLE, 0, 12.0, seed=0))
    place = locator.certain
    assert place is not None
    assert (place.node, place.keys, place.come) == (1, (0, 1, 2), 0)
    pose = place.base_in_node(level.sense(SE2(), SE2(12.0, 0.0, 0.0)))
    assert pose is not None
    assert math.hypot(pose.x, pose.y) < 0.05


def test_a_robot_carried_away_notices_within_one_edge() -> None:
    """It should come to node 1 along corridor 0, and sees what is nowhere in the atlas."""
    locator, level = located(row()), ScriptedLevel()
    locator.hear(level.departs((0.0,), 0, 0.0))
    locator.hear(level.arrives(MIDDLE, 0, 12.0, seed=77))
    assert locator.certain is None


def test_a_lost_robot_knows_where_it_is_after_two_edges_and_not_after_one() -> None:
    locator, level = Locator(row()), ScriptedLevel()
    locator.hear(level.departs((0.0,), 0, 0.0))
    locator.hear(level.arrives(MIDDLE, 0, 12.0, seed=0))
    after_one = locator.certain, locator.places[0].node
    assert after_one == (None, 1)
    locator.hear(level.departs(MIDDLE, 1, 12.0))
    locator.hear(level.arrives((math.pi,), 0, 24.0, seed=1))
    after_two = locator.certain
    assert after_two is not None
    assert after_two.node == 2


def test_off_the_graph_odometry_leads_and_reaching_it_again_keeps_the_place() -> None:
    locator, level = located(row()), ScriptedLevel()
    locator.hear(level.departs((0.0,), 0, 0.0))
    half = level.sense(SE2(6.0, 0.0, 0.0), SE2(6.0, 0.0, 0.0))
    locator.leave(half)
    place = locator.certain
    assert place is not None
    aside = place.base_in_node(level.sense(SE2(6.0, 0.8, 1.0), None))
    assert aside is not None
    assert math.dist(aside, (6.0, 0.8, 1.0)) < 1e-9


def test_two_places_alike_are_no_place() -> None:
    config = row().config
    here = UncertainPose.exact(SE2())
    first, second = Place(0, here, 1, 20.0), Place(1, here, 1, 20.0 - config.close_margin)
    assert beyond_doubt([first, second], config) is first
    assert beyond_doubt([first, Place(1, here, 1, second.evidence + 0.1)], config) is None
    assert beyond_doubt([Place(0, here, 1, config.close_evidence - 0.1)], config) is None
    assert beyond_doubt([], config) is None
