"""Where on a known edge the robot is: what it has seen about it, matched with the edge's map."""

import math
from dataclasses import replace

import numpy as np

from hslam_atlas.config import AtlasConfig
from hslam_atlas.map_match import match_constellations
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.edge_map_transform import reverse
from hslam_types.se2 import SE2, wrap

_FEWEST_PAIRS = 4
"""One more than two maps need to match at all: the pose is given by the few about the robot."""
_HEADING_STD = math.radians(4.0)
"""Of where the robot is thought to face; set by hand."""
_POSITION_STD_M, _PER_METRE = 0.1, 0.015
"""Of where the robot is thought to be: a part that is always there, and a part of the way driven."""


def base_on_edge(stored: EdgeMap, so_far: EdgeMap, expected: SE2, config: AtlasConfig) -> UncertainPose | None:
    """Return the robot's pose in a stored map's frame (m, rad); None where too little matches.

    ``so_far``: the map of the way that led here, its terminal where the robot is; ``expected``: the pose as it is
    thought to be.  The landmarks nearest to the robot say it, so a map that bends on its way here does no harm.
    """
    about = reverse(so_far)  # its origin is where the robot is
    base_in_about = SE2(0.0, 0.0, wrap(so_far.robot_at_arrival.theta - math.pi))
    prior = SE2(expected.x, expected.y, wrap(expected.theta - base_in_about.theta))
    moved = _moved(stored, prior)
    position = (_POSITION_STD_M + _PER_METRE * abs(so_far.terminal_x)) ** 2
    match = match_constellations(moved, about, SE2(), np.diag([position, position, _HEADING_STD**2]), config)
    if len(match.alignment.pairs) < _FEWEST_PAIRS or match.fraction < config.least_fraction:
        return None
    offset = UncertainPose(match.alignment.offset, match.alignment.offset_covariance)
    return UncertainPose.exact(prior) @ offset @ UncertainPose.exact(base_in_about)


def _moved(stored: EdgeMap, frame: SE2) -> EdgeMap:
    """Return a map with its landmarks seen from ``frame``, their covariances turned with them.

    Its terminal is not used by a constellation, and stays.
    """
    back = frame.inverse()
    c, s = math.cos(back.theta), math.sin(back.theta)
    turn = np.kron(np.eye(1 + stored.size), np.array([[c, -s], [s, c]]))
    return replace(stored, landmarks=back.apply_all(stored.landmarks), covariance=turn @ stored.covariance @ turn.T)
