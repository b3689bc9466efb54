"""No node can reach the truth: only the report and the command line import it."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MAY_KNOW = {"hslam_report", "hslam_bringup", "bench", "test"}
SKIP = {".oldest", ".venv", "build", "install", "log", "runs"}


def imported(path: Path) -> set[str]:
    """Return the modules a file imports, ``from a import b`` as a and a.b."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update({node.module, *(f"{node.module}.{alias.name}" for alias in node.names)})
    return names


def test_only_the_report_and_the_command_line_import_the_truth() -> None:
    knowing = set()
    for path in ROOT.rglob("*.py"):
        parts = path.relative_to(ROOT).parts
        if SKIP & set(parts) or "test" in parts or "truth" in parts:
            continue
        if any(name.startswith("hslam_sim.truth") for name in imported(path)):
            knowing.add(path)
    assert knowing, "the report scores against the truth"
    assert {path.relative_to(ROOT).parts[0] for path in knowing} <= MAY_KNOW
    assert not [path for path in knowing if path.name.endswith("_node.py")]
