"""The parameter table of the package's README is that of the code."""

from pathlib import Path

import pytest

from hslam_gvg.gvg_node import GvgNodeConfig
from hslam_gvg.level import CONFIGURATIONS, SourceConfig
from hslam_types.config import Configuration
from hslam_types.config_table import markdown_row

README = Path(__file__).parent.parent / "README.md"


LEVELS = [group for level in CONFIGURATIONS.values() for group in level]
TABLES = [("", GvgNodeConfig), ("", SourceConfig), *LEVELS]


@pytest.mark.parametrize(("prefix", "kind"), TABLES)
def test_the_readme_lists_every_parameter_as_it_is(prefix: str, kind: type[Configuration]) -> None:
    lines = README.read_text().splitlines()
    missing = [row for row in (markdown_row(entry, prefix) for entry in kind.parameters()) if row not in lines]
    assert not missing, "missing or out of date:\n" + "\n".join(missing)
