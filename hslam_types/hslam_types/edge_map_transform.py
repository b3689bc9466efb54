"""An edge-map seen from its other end.

The paper rebuilds it from the reversed log; the map it would give is the same map expressed in the frame at
the terminal meet point whose x axis points back to the origin.  In that frame every coordinate is a sum of
old ones, so the covariance transforms exactly and twice reversed is the map again.
"""

import math
from dataclasses import replace

import numpy as np

from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2, Array, wrap


def reverse(edge_map: EdgeMap) -> EdgeMap:
    """Return the same map in the frame at its terminal, x towards its origin; ``reverse`` twice is the identity.

    The headings change places, as the origin and the terminal do: the branch come along is the one a drive back
    would depart by.  ``robot_at_arrival`` stays the pose of the drive made, expressed in the new frame.
    """
    jacobian = reverse_jacobian(edge_map.size)
    return replace(
        edge_map,
        landmarks=np.array([edge_map.terminal_x, 0.0]) - edge_map.landmarks,
        covariance=jacobian @ edge_map.covariance @ jacobian.T,
        departure_heading=wrap(edge_map.arrival_heading + math.pi),
        arrival_heading=wrap(edge_map.departure_heading + math.pi),
        robot_at_arrival=SE2(edge_map.terminal_x, 0.0, -math.pi).inverse() @ edge_map.robot_at_arrival,
    )


def reverse_jacobian(size: int) -> Array:
    """Return the derivative of the reversed map by the map, (2 + 2n) x (2 + 2n) for n landmarks.

    x' = L - x and y' = -y for every landmark, L' = L for the terminal: linear, and its own inverse.
    """
    jacobian = -np.eye(2 + 2 * size)
    jacobian[0, 0] = 1.0
    jacobian[2::2, 0] = 1.0
    return jacobian
