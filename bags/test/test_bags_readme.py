"""The parameter tables of the README are those of the code."""

from pathlib import Path

import pytest

from hslam_bags.record_configuration import RecordConfiguration
from hslam_bags.recorder import RecorderConfig
from hslam_bags.replay_configuration import ReplayConfiguration
from hslam_types.config import Configuration
from hslam_types.config_table import markdown_row

README = Path(__file__).parent.parent / "README.md"


@pytest.mark.parametrize("kind", [RecordConfiguration, RecorderConfig, ReplayConfiguration])
def test_the_readme_lists_every_parameter_as_it_is(kind: type[Configuration]) -> None:
    """Name, default, range, unit and meaning of each parameter stand in one line of the README."""
    lines = README.read_text().splitlines()
    missing = [row for row in map(markdown_row, kind.parameters()) if row not in lines]
    assert not missing, "missing or out of date:\n" + "\n".join(missing)
