"""What diagnostics tell the person beside the base."""

from diagnostic_msgs.msg import DiagnosticStatus
from scout_bench import FORWARD, Bench

from hslam_types.sensing import Velocity
from scout_driver.driver import Reading
from scout_driver.scout_messages import diagnostics_to_msg


def told(bench: Bench, readings: list[Reading]) -> tuple[bytes, str]:
    """Return level and message of the base's status."""
    _, base, _ = diagnostics_to_msg(0, bench.driver, readings[-1].state, 0).status
    return base.level, base.message


def test_an_emergency_stop_is_told_until_it_is_undone() -> None:
    bench = Bench()
    assert told(bench, bench.run(1.0, FORWARD)) == (DiagnosticStatus.OK, "ok")
    bench.base.emergency_stop = True
    assert told(bench, bench.run(1.0, FORWARD)) == (DiagnosticStatus.ERROR, "held: emergency stop")
    bench.base.emergency_stop = False
    released = "held: emergency stop released, first command to stand still"
    assert told(bench, bench.run(1.0, FORWARD)) == (DiagnosticStatus.ERROR, released)
    bench.run(0.2, Velocity())
    assert told(bench, bench.run(1.0, FORWARD)) == (DiagnosticStatus.OK, "ok")
