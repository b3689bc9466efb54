"""A step's covariance by what comes with odometry, and all that is no covariance and leaves the constants."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hslam_ekf.config import EkfConfig
from hslam_ekf.odometry_noise import NoiseSource, OdometryNoise
from hslam_ekf.server import EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, DriveStep, corridor_landmarks, drive
from hslam_types.se2 import SE2, Array, compose_jacobians
from hslam_types.sensing import OdometrySample, PlanarCovariance, Velocity

SECOND_NS = 10**9
FINE = PlanarCovariance(4e-4, 0.0, 0.0, 1e-4, 0.0, 9e-4)
FLOOR = np.array([[0.0, 0.0], [9.0, 0.0]])


def planar(matrix: Array) -> PlanarCovariance:
    """Return the upper triangle of a 3 x 3 covariance."""
    return PlanarCovariance(*matrix[np.triu_indices(3)].tolist())


roots = st.lists(st.floats(-0.3, 0.3), min_size=9, max_size=9).map(lambda row: np.array(row).reshape(3, 3))
covariances = roots.map(lambda root: root @ root.T + 1e-4 * np.eye(3))
poses = st.builds(SE2, st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-3.2, 3.2))
moves = st.builds(SE2, st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5)).filter(lambda m: m != SE2())


@given(poses, moves, covariances, st.floats(0.01, 1.0))
def test_a_twist_s_covariance_is_that_of_a_step_at_that_velocity(
    base: SE2, move: SE2, covariance: Array, seconds: float
) -> None:
    after = OdometrySample(round(seconds * SECOND_NS), base @ move, Velocity(), planar(covariance))
    got = OdometryNoise().of_step(OdometrySample(0, base), after)
    assert got is not None
    # The end of an arc of turn w and chord (x, y): the chord turns by half of what the heading does.
    by_twist = seconds * np.array([[1.0, 0.0, -move.y / 2.0], [0.0, 1.0, move.x / 2.0], [0.0, 0.0, 1.0]])
    assert got == pytest.approx(by_twist @ covariance @ by_twist.T, rel=1e-6, abs=1e-12)


@given(poses, moves, covariances, covariances)
def test_a_pose_s_covariance_gives_back_the_step_it_grew_by(base: SE2, move: SE2, old: Array, noise: Array) -> None:
    """Grown as Smith, Self and Cheeseman compound it, by the Jacobians that are tested against numeric ones."""
    by_base, by_step = compose_jacobians(base, move)
    new = by_base @ old @ by_base.T + by_step @ noise @ by_step.T
    before = OdometrySample(0, base, pose_covariance=planar(old))
    after = OdometrySample(SECOND_NS, base @ move, pose_covariance=planar(new))
    teller = OdometryNoise()
    assert teller.of_step(before, after) == pytest.approx(noise, rel=1e-6, abs=1e-9)
    assert teller.source is NoiseSource.POSE


def test_variances_that_grow_without_correlations_are_sums() -> None:
    base = SE2(3.0, 1.0, math.pi / 2.0)
    before = OdometrySample(0, base, pose_covariance=PlanarCovariance(0.1, 0.0, 0.0, 0.2, 0.0, 0.3))
    grown = PlanarCovariance(0.11, 0.0, 0.0, 0.24, 0.0, 0.31)
    got = OdometryNoise().of_step(before, OdometrySample(SECOND_NS, base @ SE2(0.1, 0.0, 0.0), pose_covariance=grown))
    assert got == pytest.approx(np.diag([0.04, 0.01, 0.01]), abs=1e-12)  # the robot faces odom's y


BAD = [
    (replace_field, value)
    for replace_field in PlanarCovariance._fields
    for value in (math.nan, math.inf, -math.inf, -1.0, 1e6)
] + [("xx", 0.0), ("tt", 0.0), ("xx", 1e-12), ("xy", 0.3)]


@pytest.mark.parametrize(("field", "value"), BAD)
def test_what_is_no_covariance_is_not_believed_and_named(field: str, value: float) -> None:
    after = OdometrySample(SECOND_NS, SE2(0.1, 0.0, 0.0), Velocity(), FINE._replace(**{field: value}))
    teller = OdometryNoise()
    assert teller.of_step(OdometrySample(0, SE2()), after) is None
    assert teller.source is NoiseSource.CONSTANTS
    assert teller.reason.startswith("its twist covariance ")


POSE = PlanarCovariance(0.1, 0.0, 0.01, 0.1, 0.01, 0.1)


@pytest.mark.parametrize(
    "later",
    [POSE, POSE._replace(tt=0.05), POSE._replace(xx=math.nan), POSE._replace(xx=4.0), POSE._replace(xt=0.5), None],
)
def test_a_pose_covariance_that_does_not_grow_as_one_does_is_not_believed(later: PlanarCovariance | None) -> None:
    before = OdometrySample(0, SE2(), pose_covariance=POSE)
    after = OdometrySample(SECOND_NS, SE2(0.1, 0.0, 0.0), pose_covariance=later)
    teller = OdometryNoise()
    assert teller.of_step(before, after) is None
    assert ("its pose covariance" in teller.reason) is (later is not None)


def sums(xx: float) -> PlanarCovariance:
    """Return a pose's covariance as a driver keeps it that only sums variances up."""
    return PlanarCovariance(xx, 0.0, 0.0, 0.1, 0.0, 0.1)


@pytest.mark.parametrize(
    ("later", "believed"), [(sums(0.1), False), (sums(0.2), True), (sums(1.05), True), (sums(1.2), False)]
)
def test_sums_that_stand_still_or_grow_by_more_than_a_metre_a_step_are_not_believed(
    later: PlanarCovariance, believed: bool
) -> None:
    before = OdometrySample(0, SE2(), pose_covariance=sums(0.1))
    after = OdometrySample(SECOND_NS, SE2(0.1, 0.0, 0.0), pose_covariance=later)
    assert (OdometryNoise().of_step(before, after) is not None) == believed


def test_a_base_that_cannot_move_sideways_may_say_so() -> None:
    teller = OdometryNoise()
    after = OdometrySample(SECOND_NS, SE2(0.1, 0.0, 0.0), Velocity(), FINE._replace(yy=0.0))
    assert teller.of_step(OdometrySample(0, SE2()), after) is not None
    assert teller.source is NoiseSource.TWIST


def test_a_reason_stands_as_long_as_it_holds() -> None:
    teller = OdometryNoise()
    before = OdometrySample(0, SE2(), pose_covariance=sums(0.1))
    after = OdometrySample(SECOND_NS, SE2(0.1, 0.0, 0.0), Velocity(), FINE._replace(tt=-1.0), sums(0.1))
    teller.of_step(before, after)
    assert teller.reason
    teller.of_step(before, replace(after, pose_covariance=sums(0.2)))
    assert teller.reason == ""


def test_of_a_bad_twist_and_a_good_pose_the_pose_is_taken() -> None:
    before = OdometrySample(0, SE2(), pose_covariance=PlanarCovariance(0.1, 0.0, 0.0, 0.1, 0.0, 0.1))
    grown = PlanarCovariance(0.2, 0.0, 0.0, 0.2, 0.0, 0.2)
    bad = FINE._replace(tt=-1.0)
    after = OdometrySample(SECOND_NS, SE2(0.1, 0.0, 0.0), Velocity(), bad, grown)
    teller = OdometryNoise()
    assert teller.of_step(before, after) == pytest.approx(0.1 * np.eye(3))
    assert (teller.source, teller.reason) == (NoiseSource.POSE, "")
    assert teller.of_step(before, replace(after, twist_covariance=FINE)) == pytest.approx(
        np.array(
            [[FINE.xx, 0.0, 0.0], [0.0, FINE.yy + 0.0025 * FINE.tt, 0.05 * FINE.tt], [0.0, 0.05 * FINE.tt, FINE.tt]]
        )
    )
    assert teller.source is NoiseSource.TWIST


def short_drive(covariance: PlanarCovariance | None = None) -> list[DriveStep]:
    """Return a drive along nine metres whose looks fall between two cycles, its odometry with a twist covariance."""
    rng = np.random.default_rng(3)
    steps = drive(FLOOR, corridor_landmarks(FLOOR, rng), DriveErrors(look_every=4), rng)
    return [
        replace(
            step,
            odom=replace(step.odom, twist_covariance=covariance),
            view=replace(step.view, stamp_ns=step.view.stamp_ns - 30_000_000) if step.view else None,
        )
        for step in steps
    ]


def run(steps: list[DriveStep], config: EkfConfig | None = None) -> tuple[EkfServer, list[Array]]:
    """Return the server after a drive, and the covariance of the pose after each step."""
    server = EkfServer(config)
    outs = [server.step(step.odom, step.view, step.events) for step in steps]
    return server, [out.covariance for out in outs if out.covariance is not None]


@pytest.mark.parametrize("covariance", [FINE._replace(xx=-1.0), FINE._replace(tt=1e6)])
def test_a_drive_with_bad_covariances_has_the_bits_of_one_without(covariance: PlanarCovariance) -> None:
    server, spreads = run(short_drive(covariance))
    plain, expected = run(short_drive())
    assert all(np.array_equal(a, b) for a, b in zip(spreads, expected, strict=True))
    assert (plain.noise.source, plain.noise.reason) == (NoiseSource.CONSTANTS, "it gives no covariances")
    assert server.noise.reason.startswith("its twist covariance has a variance")


def test_covariances_are_passed_over_if_so_told() -> None:
    _, spreads = run(short_drive(FINE), EkfConfig(odometry_covariances=False))
    _, expected = run(short_drive(), EkfConfig(odometry_covariances=False))
    assert all(np.array_equal(a, b) for a, b in zip(spreads, expected, strict=True))


def test_without_looks_the_pose_is_as_uncertain_as_the_steps_add_up_to() -> None:
    steps = [replace(step, view=None) for step in short_drive(FINE)]
    _, (*_, spread) = run([replace(step, events=step.events if i == 0 else ()) for i, step in enumerate(steps)])
    expected, seconds = np.zeros((3, 3)), 0.12
    for before, after in pairwise(steps):
        here = steps[0].odom.base_in_odom.to(before.odom.base_in_odom)
        step = before.odom.base_in_odom.to(after.odom.base_in_odom)
        by_here, by_step = compose_jacobians(here, step)
        by_twist = seconds * np.array([[1.0, 0.0, -step.y / 2.0], [0.0, 1.0, step.x / 2.0], [0.0, 0.0, 1.0]])
        expected = by_here @ expected @ by_here.T + by_step @ by_twist @ FINE.matrix @ by_twist.T @ by_step.T
    assert spread == pytest.approx(expected, rel=1e-3, abs=1e-9)  # the drive begins along the frame's x


def test_a_look_between_two_cycles_divides_the_step_s_noise() -> None:
    """Looks without a sighting change nothing: the way to them and the way on add up to the step."""
    blind = [
        replace(
            step,
            view=replace(step.view, sightings=()) if step.view else None,
            events=step.events if index == 0 else (),
        )
        for index, step in enumerate(short_drive(FINE))
    ]
    assert any(step.view for step in blind)
    _, halved = run(blind)
    _, whole = run([replace(step, view=None) for step in blind])
    assert halved[-1] == pytest.approx(whole[-1], rel=1e-2)
