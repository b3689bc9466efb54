"""The parameter tables of the package's README are those of the code."""

from pathlib import Path

import pytest

from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.battery import BatteryConfiguration
from hslam_sim.landmark_sensor import LandmarkConfiguration
from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.passers_by import PassersByConfiguration
from hslam_sim.run_configuration import RunConfiguration
from hslam_sim.simulation import ClockConfiguration
from hslam_sim.sonar_configuration import SonarConfiguration
from hslam_types.config import Configuration
from hslam_types.config_table import markdown_row

README = Path(__file__).parent.parent / "README.md"
TABLES: list[tuple[str, type[Configuration]]] = [
    ("", RunConfiguration),
    ("clock.", ClockConfiguration),
    ("base.", BaseConfiguration),
    ("sonar.", SonarConfiguration),
    ("landmarks.", LandmarkConfiguration),
    ("lidar.", LidarConfiguration),
    ("battery.", BatteryConfiguration),
    ("people.", PassersByConfiguration),
]


@pytest.mark.parametrize(("prefix", "kind"), TABLES)
def test_the_readme_lists_every_parameter_as_it_is(prefix: str, kind: type[Configuration]) -> None:
    """Name, default, range, unit and meaning of each parameter stand in one line of the README."""
    lines = README.read_text().splitlines()
    missing = [line for line in (markdown_row(entry, prefix) for entry in kind.parameters()) if line not in lines]
    assert not missing, "missing or out of date:\n" + "\n".join(missing)
