"""The packages' borders: what a package imports it declares, and imports go one way only."""

import ast
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = {ET.parse(path).findtext("name", ""): path.parent for path in ROOT.glob("*/package.xml")}
PYTHON = sorted(name for name, folder in PACKAGES.items() if (folder / "setup.py").exists())

KEYS = {
    "backports": "python3-rosbags-pip",
    "contourpy": "python3-matplotlib",
    "cv2": "python3-opencv",
    "hypothesis": "python3-hypothesis",
    "lz4": "python3-rosbags-pip",
    "matplotlib": "python3-matplotlib",
    "networkx": "python3-networkx",
    "numpy": "python3-numpy",
    "psutil": "python3-psutil",
    "pytest": "python3-pytest",
    "rich": "python3-rich",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "serial": "python3-serial",
    "shapely": "python3-shapely",
    "typer": "python3-typer",
    "yaml": "python3-yaml",
}
"""The rosdep key that each Python module comes with."""

WITHOUT_KEY = {"gtsam", "mcap", "mcap_ros2"}
"""Modules rosdep does not know; where ROS comes from apt they need pip, as the README says."""

SOME = {
    "hslam_gvg": {"hslam_types", "hslam_ros", "hslam_msgs", "hslam_voronoi"},
    "hslam_ekf": {"hslam_types", "hslam_ros", "hslam_msgs"},
    "hslam_landmarks": {"hslam_types", "hslam_ros", "hslam_msgs"},
    "hslam_atlas": {"hslam_types", "hslam_ros", "hslam_msgs"},
    "hslam_report": {"hslam_types", "hslam_sim"},
    "scout_driver": {"hslam_types", "hslam_ros", "hslam_msgs", "hslam_sim"},
    "hslam_sim": {"hslam_types", "hslam_ros", "hslam_msgs", "hslam_voronoi"},
    "hslam_bags": {"hslam_types", "hslam_ros", "hslam_msgs"},
    "hslam_types": set[str](),
    "hslam_voronoi": {"hslam_types"},
    "hslam_ros": {"hslam_types", "hslam_msgs"},
}
"""What of the suite a package may import; the packages not named here may import all."""


def imported(folder: Path) -> dict[str, str]:
    """Return the top-level modules that the Python files below a folder import, each with one file that does."""
    found: dict[str, str] = {}
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names = [node.module]
            found |= {name.split(".")[0]: str(path.relative_to(ROOT)) for name in names}
    return {name: path for name, path in found.items() if name not in sys.stdlib_module_names}


def declared(folder: Path, *kinds: str) -> set[str]:
    """Return the dependencies of a package of some kinds."""
    return {entry.text or "" for kind in kinds for entry in ET.parse(folder / "package.xml").iter(kind)}


@pytest.mark.parametrize("name", PYTHON)
def test_a_package_declares_what_it_imports(name: str) -> None:
    folder = PACKAGES[name]
    needed = {KEYS.get(module, module): path for module, path in imported(folder / name).items()}
    missing = needed.keys() - declared(folder, "depend", "exec_depend") - WITHOUT_KEY - {name}
    assert not missing, {module: needed[module] for module in missing}


@pytest.mark.parametrize("name", PYTHON)
def test_a_package_declares_nothing_of_the_suite_that_it_does_not_use(name: str) -> None:
    folder = PACKAGES[name]
    launched = "".join(path.read_text() for path in sorted(folder.rglob("*.py")))
    unused = {other for other in declared(folder, "depend", "exec_depend") & PACKAGES.keys() if other not in launched}
    assert not unused


@pytest.mark.parametrize("name", PYTHON)
def test_yaml_is_read_in_one_place(name: str) -> None:
    reads = re.compile(r"yaml\.(\w*load\w*|\w*Loader)\b")
    modules = {path.name for path in (PACKAGES[name] / name).rglob("*.py") if reads.search(path.read_text())}
    assert modules <= {"yaml_text.py"}, "hslam_types.yaml_text.load_yaml refuses what PyYAML lets through"


@pytest.mark.parametrize("name", sorted(SOME))
def test_imports_go_one_way(name: str) -> None:
    modules = imported(PACKAGES[name] / name)
    wrong = (modules.keys() & PACKAGES.keys()) - SOME[name] - {name}
    assert not wrong, {module: modules[module] for module in wrong}


def test_declared_dependencies_have_no_cycle() -> None:
    waiting = {
        name: declared(folder, "depend", "exec_depend", "build_depend") & PACKAGES.keys()
        for name, folder in PACKAGES.items()
    }
    while ready := [name for name, others in waiting.items() if not others]:
        waiting = {name: others - {*ready} for name, others in waiting.items() if name not in ready}
    assert not waiting


@pytest.mark.parametrize("name", PYTHON)
def test_every_node_is_an_executable_and_a_module(name: str) -> None:
    folder = PACKAGES[name]
    nodes = {path.stem for path in (folder / name).glob("*_node.py")}
    manifest = (folder / "setup.py").read_text()
    executables = (folder / name / "executables.py").read_text() if nodes else ""
    assert all(f"{node} = {name}.executables:{node}" in manifest for node in nodes), nodes
    assert all(f'{node} = executable("{name}.{node}")' in executables for node in nodes), nodes


@pytest.mark.parametrize("name", PYTHON)
def test_colcon_is_told_to_run_the_tests(name: str) -> None:
    manifest = (PACKAGES[name] / "setup.py").read_text()
    assert 'extras_require={"test": ["pytest"' in manifest, "colcon test would run nothing and report success"
