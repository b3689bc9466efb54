"""The check of the stated noise against what is seen: silent where it holds, clear where it is off by half."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from hslam_ekf.innovation_check import InnovationCheck
from hslam_ekf.noise_report import NoiseReport, standing
from hslam_ekf.odometry_noise import NoiseSource, OdometryNoise
from hslam_ekf.server import EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, DriveStep, corridor_landmarks, drive

PATH = np.array([[0.0, 0.0], [16.0, 0.0]])


def drive_with(claimed: float, seed: int = 2) -> list[DriveStep]:
    """Return a drive whose sightings claim deviations ``claimed`` times the true ones."""
    rng = np.random.default_rng(seed)
    steps = drive(PATH, corridor_landmarks(PATH, rng), DriveErrors(clutter=0.0, look_every=2), rng)
    return [
        replace(step, view=replace(step.view, sightings=tuple(
            seen._replace(range_std_m=claimed * seen.range_std_m, bearing_std=claimed * seen.bearing_std)
            for seen in step.view.sightings
        ))) if step.view else step
        for step in steps
    ]  # fmt: skip


@pytest.mark.parametrize(("claimed", "word"), [(0.4, "worse"), (1.0, ""), (2.5, "better")])
def test_a_drive_tells_deviations_that_are_not_true(claimed: float, word: str) -> None:
    server = EkfServer()
    findings = []
    for step in drive_with(claimed):
        server.step(step.odom, step.view, step.events)
        findings.append(server.innovations.finding)
    assert word in findings[-1]
    assert bool(findings[-1]) is bool(word)


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.sampled_from([0.4, 1.0, 2.4]), st.integers(1, 12))
def test_a_window_is_judged_by_the_mean_of_its_innovations(seed: int, factor: float, sightings: int) -> None:
    rng = np.random.default_rng(seed)
    check = InnovationCheck()
    for _ in range(-(-400 // (2 * sightings))):
        assert not check.finding
        check.take(factor * float(chi2.rvs(2 * sightings, random_state=rng)), 2 * sightings)
    assert ("worse" in check.finding) is (factor > 2.0)
    assert ("better" in check.finding) is (factor < 0.5)


def test_a_finding_stands_until_a_whole_window_says_otherwise() -> None:
    check = InnovationCheck()
    check.take(1200.0, 400)
    assert "3.0 times" in check.finding
    check.take(398.0, 398)
    assert check.finding
    check.take(2.0, 2)
    assert not check.finding


def test_a_misfit_is_told_each_time_it_begins() -> None:
    noise, check, report = OdometryNoise(), InnovationCheck(), NoiseReport()
    assert not report.news(noise, check) + standing(noise, check)
    told = []
    for ratio in (3.0, 3.2, 1.0, 0.2):
        check.take(400.0 * ratio, 400)
        told.append(len(report.news(noise, check)))
    assert told == [1, 0, 0, 1]
    noise.source = NoiseSource.POSE
    assert report.news(noise, check) == ["odometry is weighed by the growth of its pose covariance"]
    assert report.news(noise, check) == []
    assert len(standing(noise, check)) == 2
