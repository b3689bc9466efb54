"""The processes of a run, at their edges."""

import time
from pathlib import Path

import pytest

from hslam_bringup import fleet
from hslam_bringup.fleet import Fleet, NodeProcess
from hslam_ros.private_domain import private_domain

PATIENCE_S = 30.0


def test_a_node_that_is_stopped_while_it_imports_prints_no_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = tmp_path / "node.py"
    node.write_text("#!/usr/bin/env python3\nprint('importing', flush=True)\nimport time\ntime.sleep(600)\n")
    node.chmod(0o755)
    monkeypatch.setattr(fleet, "executable", lambda *_: node)
    with private_domain() as domain:
        nodes = Fleet(tmp_path / "log", domain)
        nodes.start(NodeProcess("slow", "none", "none"))
        until = time.monotonic() + PATIENCE_S
        while not nodes.log("slow").read_text():
            assert time.monotonic() < until
        nodes.stop(["slow"])
    assert nodes.log("slow").read_text() == "importing\n"
