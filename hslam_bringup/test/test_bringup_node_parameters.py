"""Settings are checked before a run begins, against the very parameters that its nodes declare."""

from collections.abc import Callable

import pytest
from rclpy.node import Node
from ros_stage import Stage, Staged

from hslam_atlas.atlas_node import AtlasNode
from hslam_bringup.node_parameters import ALGORITHMS, NODES, check_settings, groups_of, parameters
from hslam_ekf.ekf_node import EkfNode
from hslam_gvg.gvg_node import GvgNode
from hslam_landmarks.scan_landmarks_node import ScanLandmarksNode
from hslam_sim.sim_node import SimNode
from hslam_types.errors import ConfigurationError
from scout_driver.scout_emulator import EmulatorNode
from scout_driver.scout_node import ScoutNode

OF_RCLPY = {"use_sim_time", "start_type_description_service"}
LISTS = {"lockstep_nodes", "lockstep_suspects"}
"""Not settable: the run says who waits for whom."""
NODE_CLASSES: dict[str, Callable[[], Node]] = {
    "sim": SimNode,
    "gvg": GvgNode,
    "scan_landmarks": ScanLandmarksNode,
    "ekf": EkfNode,
    "atlas": AtlasNode,
    "scout": ScoutNode,
    "scout_emulator": EmulatorNode,
}


@pytest.mark.parametrize("name", NODES)
def test_a_run_knows_every_parameter_of_its_nodes(staged: Staged, name: str) -> None:
    node = staged(Stage).add(NODE_CLASSES[name]())
    known = {entry.name for entry in parameters(groups_of(name, NODES, {}))}
    assert set(node.get_parameters_by_prefix("")) - OF_RCLPY - LISTS == known


def test_whole_numbers_do_for_real_ones() -> None:
    check_settings({"ekf": {"accept_gate": 9, "map_every_s": 1.0}, "sim": {"sonar.noise_fraction": 0}}, NODES)


def test_the_source_says_which_parameters_the_gvg_level_has() -> None:
    check_settings({"gvg": {"source": "scan", "map.cell_m": 0.05, "graph.site_m": 0.1}}, ALGORITHMS)
    with pytest.raises(ConfigurationError, match="no parameter 'wide_m'"):
        check_settings({"gvg": {"source": "scan", "wide_m": 2.0}}, ALGORITHMS)


@pytest.mark.parametrize(
    ("node", "name", "value", "told"),
    [
        ("ekf", "acept_gate", 9.0, "ekf has no parameter 'acept_gate' here; it has: accept_gate,"),
        ("sim", "noise_fraction", 0.1, "sim has no parameter 'noise_fraction'"),
        ("sim", "sonar.noise_fraction", "much", "'sonar.noise_fraction' must be of type float"),
        ("ekf", "accept_gate", -1.0, "'accept_gate' = -1.0 is outside"),
        ("ekf", "map_every_s", 1.0, "ekf has no parameter 'map_every_s' here"),
        ("gvg", "map.cell_m", 0.05, "gvg has no parameter 'map.cell_m' here"),
        ("gvg", "source", "smell", "'source' must be ring or scan"),
    ],
)
def test_a_setting_that_cannot_be_is_refused(node: str, name: str, value: object, told: str) -> None:
    with pytest.raises(ConfigurationError, match=told):
        check_settings({node: {name: value}}, ALGORITHMS)
