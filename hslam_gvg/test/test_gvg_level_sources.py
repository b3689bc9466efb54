"""Which level a source and a way of driving make, and with which parameters."""

import pytest

from hslam_gvg.graph_follower import GraphFollower
from hslam_gvg.level import level_from_mapping
from hslam_gvg.server import GvgServer
from hslam_types.errors import ConfigurationError
from hslam_types.se2 import SE2
from hslam_types.sensing import SCOUT_RING, OdometrySample, SonarPing, SonarSweep


def test_a_ring_is_driven_by_laws_unless_told_otherwise() -> None:
    assert isinstance(level_from_mapping({})[0], GvgServer)
    assert isinstance(level_from_mapping({"drive": "graph"})[0], GraphFollower)


def test_a_scanner_is_always_driven_along_the_graph() -> None:
    level, source = level_from_mapping({"source": "scan"})
    assert isinstance(level, GraphFollower)
    assert source.level == "scan"


def test_the_ring_along_the_graph_has_its_own_defaults_and_groups() -> None:
    settings = {"drive": "graph", "map.support": 3.0, "guard.creep_m_s": 0.05}
    level, _ = level_from_mapping(settings)
    assert isinstance(level, GraphFollower)
    assert level.config.listening_turn > 0.0
    with pytest.raises(ConfigurationError, match="creep"):
        level_from_mapping({"drive": "graph", "creep_m_s": 0.05})


def test_another_way_of_driving_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="'drive' must be laws, graph or none, not 'map'"):
        level_from_mapping({"drive": "map"})


def test_the_ring_along_the_graph_hears_sweeps() -> None:
    level, _ = level_from_mapping({"drive": "graph"})
    for cycle in range(1, 60):
        stamp_ns = cycle * 120_000_000
        pings = tuple(SonarPing(i, stamp_ns, 1.0) for i in (cycle % 16, (cycle + 8) % 16))
        base = SE2(0.03 * cycle, 0.0, 0.0)
        level.step(OdometrySample(stamp_ns, base), SonarSweep(stamp_ns, SCOUT_RING, pings))
    assert len(level.obstacle_points()) > 10
