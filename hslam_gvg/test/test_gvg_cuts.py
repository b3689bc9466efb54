"""Known answers of where the local graph is cut, and how far it may go on beyond."""

import math

import numpy as np
import pytest

from hslam_gvg.local_graph.cuts import at_end_of_free, in_gaps
from hslam_gvg.local_graph.graph_config import LocalGraphConfig
from hslam_types.se2 import Array

LINE: Array = np.array([[0.0, 0.0, 1.0], [2.0, 0.0, 1.0]])
LINK = np.array([[0, 1]])
KNOWN = np.array([True, False])


@pytest.mark.parametrize(("horizon_m", "far"), [(9.0, False), (0.5, True)])
def test_a_ridge_is_followed_as_far_as_the_space_on_it_is_free(horizon_m: float, far: bool) -> None:
    config = LocalGraphConfig(into_free_m=1.5, exit_credit=3.0)
    sites = np.array([[0.7, 0.5]])
    vertices, links, beyond = at_end_of_free(
        LINE, LINK.copy(), KNOWN, sites, lambda x, y: x + y < 0.75, config, horizon_m
    )
    assert links.tolist() == [[0, 2]]
    assert vertices[2] == pytest.approx([0.7, 0.0, 0.5])
    assert beyond == {2: pytest.approx(math.inf if far else 3.0 * 0.5)}


def test_a_doubted_gap_ends_what_comes_to_it_from_the_known_alone() -> None:
    vertices = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]])
    middle = np.array([[0.5, 0.0, 0.4], [1.5, 0.0, 0.3]])
    known, doubted = np.array([True, False, False]), np.array([True, True])
    found, links, ends = in_gaps(vertices, np.array([[0, 1], [1, 2]]), known, middle, doubted)
    assert links.tolist() == [[0, 3]]
    assert found[3] == pytest.approx(middle[0])
    assert ends == {3: 0.0}
