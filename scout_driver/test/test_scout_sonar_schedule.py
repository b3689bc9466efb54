"""When each sonar was fired, and what it heard."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scout_driver.config import DriverConfig
from scout_driver.protocol.replies import State
from scout_driver.sonar_schedule import SonarSchedule

CYCLE_S = 0.06


def frame(sonar: tuple[int, ...]) -> State:
    """Return a state of a base at rest."""
    return State(sonar, bumper=0, x=0, y=0, heading=0, right=0, left=0)


@pytest.mark.parametrize("phase_s", [0.0, 0.21, 0.5, 0.93])
@pytest.mark.parametrize("told", [True, False])
def test_sonar_firings_are_dated(phase_s: float, *, told: bool) -> None:
    """A board fires at known moments; the schedule has to find them, told of CONF_SN or not."""
    config, rng = DriverConfig(), np.random.default_rng(3)
    order, schedule = config.firing_order(), SonarSchedule(config)
    registers, fired = [50] * 16, 0
    if told:
        schedule.restart(phase_s - 0.06)
    errors = []
    for i in range(1000):
        now_s = i * 0.0637  # not in step with the pings, as no real cycle is
        while phase_s + fired * 0.06 + 0.01 <= now_s:
            registers[order[fired % 16]] = int(rng.integers(20, 120))
            fired += 1
        for when_s, ping in schedule.pings(frame(tuple(registers)), now_s):
            nearest = round((when_s - phase_s) / 0.06)
            # A firing put to the wrong sonar is off by a whole number of pings.
            rank_error = (nearest - order.index(ping.sensor) + 8) % 16 - 8
            errors.append(abs(when_s - phase_s - nearest * 0.06) + 0.06 * abs(rank_error))
    settled = errors if told else errors[len(errors) // 4 :]
    assert max(settled) < 0.03
    assert len(errors) == pytest.approx(fired, abs=3 if told else 40)


@given(st.floats(0.0, 10.0), st.floats(0.0, 0.96))
def test_cycles_come_into_step_with_the_echoes(began_s: float, first_s: float) -> None:
    schedule = SonarSchedule(DriverConfig())
    schedule.restart(first_s)
    for _ in range(10):
        wait_s = schedule.next_cycle_s(began_s, CYCLE_S)
        assert 0.8 * CYCLE_S - 1e-9 <= wait_s <= 1.2 * CYCLE_S + 1e-9
        began_s += wait_s
    assert math.remainder(began_s - schedule.phase_s, 0.06) == pytest.approx(math.remainder(0.04, 0.06), abs=1e-6)


def test_a_cycle_that_is_no_multiple_of_a_ping_is_left_alone() -> None:
    assert SonarSchedule(DriverConfig()).next_cycle_s(0.01, 0.05) == 0.05


def sweep(config: DriverConfig, registers: tuple[int, ...]) -> dict[int, list[float]]:
    """Return the ranges heard of each sonar over two sweeps with registers that never change."""
    schedule, heard = SonarSchedule(config), dict[int, list[float]]()
    schedule.restart(0.0)
    for i in range(40):
        for _, ping in schedule.pings(frame(registers), i * CYCLE_S):
            heard.setdefault(ping.sensor, []).append(ping.range_m)
    return heard


@pytest.mark.parametrize("no_echo", [255, 200])
def test_a_register_without_an_echo_is_no_range(no_echo: int) -> None:
    registers = tuple(range(no_echo - 8, no_echo)) + tuple(min(255, no_echo + i) for i in range(8))
    heard = sweep(DriverConfig(sonar_no_echo=no_echo), registers)
    assert sorted(heard) == list(range(16))
    for sensor, ranges in heard.items():
        inches = registers[sensor]
        expected = math.inf if inches >= no_echo else inches * 0.0254
        assert len(ranges) >= 2
        assert ranges == pytest.approx([expected] * len(ranges))


def test_a_sonar_that_has_not_fired_yet_says_nothing() -> None:
    registers = (0, *(50,) * 7, 0, *(50,) * 7)
    assert sorted(sweep(DriverConfig(), registers)) == [s for s in range(16) if registers[s]]


@pytest.mark.parametrize("changed", [5, 16])
def test_damaged_frames_do_not_vote(changed: int) -> None:
    """Nothing moves, but once a sweep, always at the same point of it, a frame comes with readings of its own."""
    schedule, order = SonarSchedule(DriverConfig()), DriverConfig().firing_order()
    schedule.restart(0.0)
    still = (60,) * 16
    damaged = tuple(90 if sensor in order[3 : 3 + changed] or changed == 16 else 60 for sensor in range(16))
    for i in range(1, 1600):
        schedule.pings(frame(damaged if i % 16 == 7 else still), i * CYCLE_S)
        assert schedule.phase_s == pytest.approx(CYCLE_S)
