"""Commands of the set-up: their output goes to the log, a person reads how far they are and, if they fail, why."""

import io
import os
import re
import sys
from pathlib import Path

import pytest
import set_up
from commands import Commands, CutShortError, Display, Stand
from machine import SetUpError


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def python(commands: Commands, program: str) -> None:
    commands.run([sys.executable, "-c", program], os.environ, "this step", lambda printed: Stand(1.0, printed.strip()))


def test_what_commands_print_is_in_one_log_alone(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log" / "set-up.log"
    log.parent.mkdir()
    log.write_text("of the set-up before\n")
    commands = Commands(log, tmp_path, out := io.StringIO())
    python(commands, "print('WARNING: one')")
    python(commands, "import sys; print('two', file=sys.stderr)")
    assert re.sub("==> .*", "==>", log.read_text()) == "==>\nWARNING: one\n==>\ntwo\n"
    assert capfd.readouterr() == ("", "")
    assert out.getvalue() == "set-up: this step: WARNING: one, 0:00\nset-up: this step: two, 0:00\n"


def test_a_failure_shows_its_last_lines_and_the_log(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    commands = Commands(tmp_path / "log", tmp_path, io.StringIO())
    python(commands, "print('of the step before')")
    with pytest.raises(SetUpError, match=f"this step failed; the whole output is in {tmp_path}/log"):
        python(commands, "for n in range(30): print('line', n)\nraise SystemExit(1)")
    assert capfd.readouterr().err == "".join(f"line {n}\n" for n in range(10, 30))
    with pytest.raises(CutShortError, match="this step was ended by SIGKILL; the whole"):
        python(commands, "import os; os.kill(os.getpid(), 9)")


def test_off_a_terminal_the_start_and_every_quarter_are_a_line() -> None:
    display = Display("this step", out := io.StringIO())
    for done in range(9):
        display.show(Stand(done / 8, f"{done} of 8"))
    display.close()
    assert re.findall(r"(\d) of 8, 0:00\n", out.getvalue()) == ["0", "2", "4", "6", "8"]


def test_on_a_terminal_one_line_is_drawn_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    display = Display("this step", out := Terminal())
    for done in range(9):
        display.show(Stand(done / 8, f"{done} of 8"))
    display.close()
    drawn = out.getvalue().split("\r")[1:]
    assert drawn[4] == "set-up: this step [############............] 4 of 8, 0:00\x1b[K"
    assert drawn[-1].endswith("\n")
    assert all(len(line.removesuffix("\x1b[K")) < 60 for line in drawn[:-1])


def test_what_colcon_prints_tells_how_far_it_is() -> None:
    printed = "Starting >>> a\nStarting >>> b\nFinished <<< b [0.5s]\nStarting >>> c\n"
    assert set_up.built(printed, 4) == Stand(0.25, "1 of 4 packages, now a, c")
    assert set_up.built(printed + "Finished <<< a [1.5s]\nFinished <<< c [1s]\n", 4).text == "3 of 4 packages"
