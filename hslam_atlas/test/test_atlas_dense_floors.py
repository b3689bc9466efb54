"""Floors whose places are hard to tell apart: no two may become one node, no way may be given up for another."""

from dataclasses import replace

import numpy as np
import pytest
from corridor_floor import Corridor, furnish
from dense_floors import office, theta
from edge_walker import WalkNoise
from explored import explore

CALM = WalkNoise(degree_misread=0.0, node_missed=0.0)
TWO_DOORS = (
    Corridor(0, 1, ((0.0, 0.0), (6.0, 0.0)), 1.4),
    Corridor(1, 2, ((6.0, 0.0), (7.1, 0.0)), 1.4),
    Corridor(2, 3, ((7.1, 0.0), (12.0, 0.0)), 1.4),
    Corridor(1, 4, ((6.0, 0.0), (6.0, 3.0)), 1.4),
    Corridor(2, 5, ((7.1, 0.0), (7.1, -3.0)), 1.4),
)


@pytest.mark.parametrize("unheard", [0.0, 1.0])
@pytest.mark.parametrize("gap_m", [1.0, 4.0])
def test_two_doors_nearer_than_a_clearance_are_two_nodes(unheard: float, gap_m: float) -> None:
    """The way between them ends within the free disc it began in, all the more where walls are not heard."""
    floor = furnish(TWO_DOORS, np.random.default_rng(3), gap_m=gap_m)
    end = explore(floor, 0, 3, replace(CALM, walls_unheard=unheard))
    assert end.finished
    assert end.false_closures() == 0
    assert end.is_isomorphic()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("skew_m", [0.0, 0.4])
def test_all_three_ways_of_a_theta_are_found(seed: int, skew_m: float) -> None:
    """The outer ways are of one length and share the landmarks about both nodes; only their directions differ."""
    floor = furnish(theta(4.0, 5.0, skew_m), np.random.default_rng(seed))
    end = explore(floor, seed % 2, seed, WalkNoise())
    assert end.finished
    assert end.is_isomorphic()


@pytest.mark.parametrize("seed", [0, 1])
def test_an_office_of_short_ways_with_few_landmarks(seed: int) -> None:
    floor = furnish(office(6, np.random.default_rng(5000 + seed)), np.random.default_rng(1000 + seed), gap_m=4.0)
    end = explore(floor, 0, seed, CALM)
    assert end.finished
    assert end.false_closures() == 0
    assert end.is_isomorphic()
