"""Only the answer to the last command counts: nothing left over on the line, nothing late, nothing of another type."""

from dataclasses import replace

from scout_bench import Bench

from scout_driver.emulator.config import FaultConfig
from scout_driver.protocol.commands import CommandKind
from scout_driver.protocol.framing import encode_frame
from scout_driver.protocol.replies import state_to_frame


def standing() -> Bench:
    """Return a driver that only asks for states, at rest."""
    bench = Bench()
    bench.run(1.0, None)
    return bench


def slip_in(bench: Bench, kind: CommandKind, after_s: float) -> None:
    """Let a reply that nobody asked for arrive, which shows a contact."""
    reply = encode_frame(state_to_frame(replace(bench.base.state(), bumper=1), kind))
    bench.line._leaving.append((bench.clock.now() + after_s, reply))


def contact_told(bench: Bench) -> bool:
    """Carry out an exchange; tell whether its answer shows a contact."""
    reading = bench.driver.cycle()
    assert reading is not None
    return reading.state.bumper != 0


def test_a_reply_left_on_the_line_is_not_the_answer_to_the_next_command() -> None:
    bench = standing()
    slip_in(bench, CommandKind.STATE, 0.0)
    assert not contact_told(bench)


def test_a_reply_of_another_type_is_waited_over() -> None:
    bench = standing()
    unexpected = bench.driver.counts.unexpected
    slip_in(bench, CommandKind.VELOCITY, 0.005)
    assert not contact_told(bench)
    assert bench.driver.counts.unexpected == unexpected + 1


def test_after_a_silence_the_line_is_listened_to_before_it_is_spoken_to() -> None:
    bench = standing()
    bench.silence(deaf=True)
    assert bench.driver.cycle() is None
    bench.silence(deaf=False)
    slip_in(bench, CommandKind.STATE, 0.005)
    assert not contact_told(bench)


def test_a_refusal_ends_the_exchange_at_once() -> None:
    bench = Bench(faults=FaultConfig(nak=1.0))
    bench.driver.cycle()
    began_s = bench.clock.now()
    bench.driver.cycle()
    counts = bench.driver.counts
    assert (counts.refused, counts.broken, counts.silent) == (2, 0, 0)
    assert bench.clock.now() - began_s < bench.config.reply_timeout_s
