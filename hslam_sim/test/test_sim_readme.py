"""The parameter tables of the package's README are those of the code."""

from pathlib import Path

import pytest

from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.battery import BatteryConfiguration
from hslam_sim.landmark_sensor import LandmarkConfiguration
from hslam_sim.sim_node import RunConfiguration
from hslam_sim.simulation import ClockConfiguration
from hslam_sim.sonar_configuration import SonarConfiguration
from hslam_types.config import Configuration, Parameter

README = Path(__file__).parent.parent / "README.md"
TABLES: list[tuple[str, type[Configuration]]] = [
    ("", RunConfiguration),
    ("clock.", ClockConfiguration),
    ("base.", BaseConfiguration),
    ("sonar.", SonarConfiguration),
    ("landmarks.", LandmarkConfiguration),
    ("battery.", BatteryConfiguration),
]


def row(prefix: str, entry: Parameter) -> str:
    """Return the README's line for a parameter."""
    default = f"{entry.default:.4g}" if isinstance(entry.default, float) else str(entry.default).lower()
    bounds = "" if isinstance(entry.default, bool | str) else f"{entry.low:g} to {entry.high:g}"
    return f"| `{prefix}{entry.name}` | {default} | {bounds} | {entry.unit} | {entry.meaning} |"


@pytest.mark.parametrize(("prefix", "kind"), TABLES)
def test_the_readme_lists_every_parameter_as_it_is(prefix: str, kind: type[Configuration]) -> None:
    """Name, default, range, unit and meaning of each parameter stand in one line of the README."""
    lines = README.read_text().splitlines()
    missing = [line for line in (row(prefix, entry) for entry in kind.parameters()) if line not in lines]
    assert not missing, "missing or out of date:\n" + "\n".join(missing)
