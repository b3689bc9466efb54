"""The server over events: which event makes what, against a drive whose truth is known."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hash_seeds import under_two_hash_seeds

from hslam_ekf.config import EkfConfig
from hslam_ekf.errors import EkfError
from hslam_ekf.server import EkfOutput, EkfServer
from hslam_ekf.synthetic_drive import DriveErrors, DriveStep, corridor_landmarks, drive
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent
from hslam_types.se2 import SE2, Array, wrap
from hslam_types.sensing import LandmarkView

PATH = np.array([[2.0, 1.0], [14.0, 1.0], [14.0, 8.0]])
LENGTH = math.hypot(12.0, 7.0)
EDGE = SE2(2.0, 1.0, math.atan2(7.0, 12.0))


def one_drive(seed: int = 0, errors: DriveErrors | None = None) -> tuple[list[DriveStep], Array]:
    """Return a drive round one corner, and its landmarks."""
    rng = np.random.default_rng(seed)
    landmarks = corridor_landmarks(PATH, rng)
    return drive(PATH, landmarks, errors or DriveErrors(), rng), landmarks


def run(steps: list[DriveStep], server: EkfServer | None = None) -> list[EkfOutput]:
    """Feed a drive to a server."""
    server = server or EkfServer()
    return [server.step(step.odom, step.view, step.events) for step in steps]


def products(outputs: list[EkfOutput]) -> tuple[list[EdgeMap], list[FrameLink]]:
    """Return all edge-maps and links of a run."""
    return [m for out in outputs for m in out.edge_maps], [link for out in outputs for link in out.links]


def test_a_traversal_gives_one_map_and_one_link() -> None:
    steps, landmarks = one_drive()
    (edge_map,), (link,) = products(run(steps))
    assert (edge_map.traversal, edge_map.arrival) == (0, 1)
    assert (link.traversal, link.departure) == (0, 2)
    assert edge_map.terminal_x == pytest.approx(LENGTH, abs=0.15)
    true = EDGE.inverse().apply_all(landmarks)
    nearest = np.linalg.norm(edge_map.landmarks[:, None] - true[None], axis=2)
    assert nearest.min(axis=1).max() < 0.25
    assert len(set(nearest.argmin(axis=1).tolist())) == edge_map.size == len(landmarks)
    assert edge_map.covariance.shape == (2 + 2 * len(landmarks), 2 + 2 * len(landmarks))
    assert not edge_map.covariance[1].any()
    departure_heading = EDGE.to(steps[0].base_in_map).theta
    assert abs(wrap(edge_map.departure_heading - departure_heading)) < 0.02
    at_arrival = next(step for step in steps if step.events and step.events[0].kind is EventKind.ARRIVAL)
    assert abs(wrap(edge_map.arrival_heading - EDGE.to(at_arrival.base_in_map).theta)) < 0.03
    assert edge_map.robot_at_arrival == pytest.approx(EDGE.to(at_arrival.base_in_map), abs=0.15)


def test_an_unknown_branch_ties_the_view_by_the_first() -> None:
    """As the atlas reads it: `NodeView.reference_bearing`."""
    steps, _ = one_drive()
    at = next(i for i, step in enumerate(steps) if step.events and step.events[0].kind is EventKind.ARRIVAL)
    (arrival,) = steps[at].events
    assert arrival.node is not None
    node = replace(arrival.node, bearings_in_odom=(0.3, 2.5, -1.0))
    headings = []
    for branch in (0, -1):
        event = replace(arrival, node=node, branch=branch)
        (edge_map,), _ = products(run([*steps[:at], replace(steps[at], events=(event,)), *steps[at + 1 :]]))
        headings.append(edge_map.arrival_heading)
    assert headings[0] == headings[1]


def test_the_link_and_the_pose_follow_the_truth() -> None:
    steps, _ = one_drive(seed=3)
    outputs = run(steps)
    _, (link,) = products(outputs)
    next_frame = SE2(14.0, 8.0, steps[-1].base_in_map.theta)
    error = link.departure_in_edge.to(EDGE.to(next_frame))
    assert math.hypot(error.x, error.y) < 0.15
    assert abs(error.theta) < 0.04
    before = outputs[-2]
    assert before.arrived
    assert before.base_in_edge == pytest.approx(EDGE.to(steps[-2].base_in_map), abs=0.15)
    last = outputs[-1]
    assert (last.traversal, last.arrived) == (2, False)
    assert last.base_in_edge == pytest.approx(next_frame.to(steps[-1].base_in_map), abs=1e-9)
    assert last.covariance is not None
    assert not last.covariance.any()


def bits_of_a_drive() -> str:
    """Return a drive's map and link, to the last bit."""
    steps, _ = one_drive(seed=1)
    (edge_map,), (link,) = products(run(steps))
    arrays = (edge_map.landmarks, edge_map.covariance, link.covariance)
    return repr((edge_map.sightings, link.departure_in_edge, *(array.tobytes() for array in arrays)))


def test_same_input_same_bits() -> None:
    first, second = under_two_hash_seeds(bits_of_a_drive)
    assert first == second


def test_before_any_event_nothing_is_known() -> None:
    steps, _ = one_drive()
    out = EkfServer().step(steps[1].odom, steps[1].view, ())
    assert out.base_in_edge is None
    assert out.traversal == -1


def test_access_tracks_but_makes_no_map() -> None:
    steps, _ = one_drive()
    access = replace(steps[0].events[0], kind=EventKind.ACCESS, node=None, branch=-1)
    outputs = run([replace(steps[0], events=(access,)), *steps[1:]])
    assert products(outputs) == ([], [])
    assert outputs[0].base_in_edge == SE2()
    assert outputs[-1].traversal == 2


def test_lost_drops_the_traversal() -> None:
    steps, _ = one_drive()
    server = EkfServer()
    run(steps[:50], server)
    lost = GvgEvent(1, steps[50].odom.stamp_ns, EventKind.LOST)
    assert server.step(steps[50].odom, None, (lost,)).base_in_edge is None
    assert products(run(steps[51:], server)) == ([], [])


def test_the_rotation_bias_is_found_and_carried_over() -> None:
    bias = math.radians(-1.7)
    steps, _ = one_drive(errors=DriveErrors(turn_bias_per_metre=bias))
    server = EkfServer()
    run(steps, server)
    assert server.traversal is not None
    assert server.traversal.sequence == 2
    assert server.traversal.filter.mean[3] == pytest.approx(bias, abs=math.radians(0.5))
    assert 0.0 < server.traversal.filter.covariance[3, 3] < math.radians(0.3) ** 2


@pytest.mark.parametrize(
    ("known_deg", "prior_deg", "carried_deg"),
    [(0.2, 1.2, 0.2), (0.01, 1.2, 0.05), (0.0, 1.2, 0.05), (0.01, 0.03, 0.03), (0.0, 0.0, 0.0)],
)
def test_the_bias_is_never_trusted_beyond_its_floor_or_its_prior(
    known_deg: float, prior_deg: float, carried_deg: float
) -> None:
    """Standard deviations in degrees a metre; a prior of 0 keeps the bias switched off."""
    steps, _ = one_drive()
    server = EkfServer(EkfConfig(turn_bias_per_metre=math.radians(prior_deg)))
    run(steps[:-1], server)
    assert server.traversal is not None
    server.traversal.filter.covariance[3, :] = server.traversal.filter.covariance[:, 3] = 0.0
    server.traversal.filter.covariance[3, 3] = math.radians(known_deg) ** 2
    run(steps[-1:], server)
    assert server.traversal.sequence == 2
    assert server.traversal.filter.covariance[3, 3] == pytest.approx(math.radians(carried_deg) ** 2)


def test_an_empty_look_is_no_error() -> None:
    steps, _ = one_drive()
    blind = [
        replace(step, view=LandmarkView(step.view.stamp_ns, step.view.range_max_m, ()) if step.view else None)
        for step in steps
    ]
    (edge_map,), (link,) = products(run(blind))
    assert edge_map.size == 0
    assert edge_map.covariance[0, 0] > 0.0
    assert np.linalg.eigvalsh(link.covariance).min() > 0.0


def test_a_look_between_two_cycles_is_taken_on_the_way() -> None:
    noiseless = DriveErrors(0.0, 0.0, 0.0, 0.0, 1e-6, 1e-6, missed=0.0, clutter=0.0, homing_m=0.0)
    steps, landmarks = one_drive(errors=noiseless)
    precise = [
        replace(
            step,
            view=replace(
                step.view, sightings=tuple(s._replace(range_std_m=0.05, bearing_std=0.02) for s in step.view.sightings)
            ),
        )
        if step.view
        else step
        for step in steps
    ]
    # Leave out the cycles with looks, and let the looks arrive with the next cycle under their own stamps.
    thinned = [
        replace(after, view=before.view) for before, after in pairwise(precise) if after.view is None or after.events
    ]
    (edge_map,), _ = products(run([precise[0], *thinned]))
    assert edge_map.terminal_x == pytest.approx(LENGTH, abs=0.02)
    gaps = np.linalg.norm(edge_map.landmarks[:, None] - EDGE.inverse().apply_all(landmarks)[None], axis=2)
    assert gaps.min(axis=1).max() < 0.02


@pytest.mark.parametrize("stamped_like", [16, 19])
def test_a_look_not_younger_than_the_last_cycle_is_left_out(stamped_like: int) -> None:
    """Step 19 is the last one taken: a look at its stamp has been used, or came too late for it."""
    steps, _ = one_drive()
    server, other = EkfServer(), EkfServer()
    run(steps[:20], server)
    run(steps[:20], other)
    assert steps[16].view is not None
    again = replace(steps[16].view, stamp_ns=steps[stamped_like].odom.stamp_ns)
    late, none = server.step(steps[20].odom, again, ()), other.step(steps[20].odom, None, ())
    assert late.base_in_edge == none.base_in_edge
    assert np.array_equal(late.covariance, none.covariance)  # type: ignore[arg-type]


def test_a_look_at_a_departure_serves_the_traversal_that_ends_there_and_no_other() -> None:
    errors = next(e for e in (DriveErrors(look_every=n) for n in range(2, 9)) if one_drive(errors=e)[0][-1].view)
    steps, _ = one_drive(errors=errors)
    links, servers = [], []
    for last in (steps[-1], replace(steps[-1], view=None)):
        servers.append(EkfServer())
        links += products(run([*steps[:-1], last], servers[-1]))[1]
        traversal = servers[-1].traversal
        assert traversal is not None
        assert (traversal.sequence, len(traversal.filter.landmarks)) == (2, 0)
    assert links[0].departure_in_edge != links[1].departure_in_edge
    assert np.trace(links[0].covariance) < np.trace(links[1].covariance)


@pytest.mark.parametrize("change", [{"node": None}, {"branch": 7}, {"branch": -1}])
def test_a_departure_without_a_branch_is_refused(change: dict[str, int | None]) -> None:
    steps, _ = one_drive()
    event = replace(steps[0].events[0], **change)  # type: ignore[arg-type]
    with pytest.raises(EkfError):
        EkfServer().step(steps[0].odom, None, (event,))


def test_the_map_so_far_is_the_map_to_be_and_the_filter_goes_on() -> None:
    """Asked at every step, what it said last fits the map at the end, and that has the bits of a drive not asked."""
    steps, _ = one_drive()
    server, asked = EkfServer(), []
    outputs = []
    for step in steps:
        outputs.append(server.step(step.odom, step.view, step.events))
        asked.append(server.so_far())
    (undisturbed,), _ = products(run(one_drive()[0]))
    (edge_map,), _ = products(outputs)
    assert edge_map.covariance.tobytes() == undisturbed.covariance.tobytes()
    before = next(i for i, out in enumerate(outputs) if out.edge_maps) - 1
    last = asked[before]
    assert last is not None
    assert asked[before + 1] is None, "past its end there is none under way"
    assert abs(last.size - edge_map.size) <= 3
    assert last.terminal_x == pytest.approx(edge_map.terminal_x, abs=0.2)
    assert last.robot_at_arrival.y == pytest.approx(0.0, abs=1e-9)
