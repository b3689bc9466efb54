"""The parameter tables of the package's README are those of the code."""

from pathlib import Path

import pytest

from hslam_landmarks.config import ScanLandmarksConfig, ScannerConfig
from hslam_landmarks.scan_landmarks_node import LinkConfig
from hslam_types.config import Configuration
from hslam_types.config_table import markdown_row

README = Path(__file__).parent.parent / "README.md"


@pytest.mark.parametrize("kind", [LinkConfig, ScannerConfig, ScanLandmarksConfig])
def test_the_readme_lists_every_parameter_as_it_is(kind: type[Configuration]) -> None:
    lines = README.read_text().splitlines()
    missing = [row for row in map(markdown_row, kind.parameters()) if row not in lines]
    assert not missing, "missing or out of date:\n" + "\n".join(missing)
