"""A disk that is full when a run ends: one line, and what was learnt is kept."""

import errno
import json
from pathlib import Path
from typing import NoReturn

import pytest

from hslam_bringup import cli, run_report
from hslam_bringup.in_process_run import run_in_process
from hslam_bringup.run_options import RunOptions, prepare_output


def full_disk(*_: object, **__: object) -> NoReturn:
    """Fail as a write to a full disk does."""
    raise OSError(errno.ENOSPC, "No space left on device", "/runs/figure.png")


def test_figures_without_room_leave_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options = RunOptions("small_world", 1, tmp_path / "run", {}, 12.0, "sim")
    prepare_output(options.out, force=False)
    end = run_in_process(options, lambda _: None)
    monkeypatch.setattr(run_report, "write_figures", full_disk)
    with pytest.raises(OSError, match="No space left"):
        run_report.report_run(options, end, 1.0)
    assert json.loads(options.report.read_text())["world"] == "small_world"


def test_a_full_disk_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(cli, "app", full_disk)
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 1
    assert capsys.readouterr().err == "hslam: [Errno 28] No space left on device: '/runs/figure.png'\n"
