"""A robot put down at random places of a known atlas, scored against the simulator's truth."""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from hslam_atlas.missions.localise import Localise
from hslam_atlas.state import AtlasState
from hslam_bringup.atlas_truth import true_edge_frames
from hslam_bringup.errand import Errand, atlas_state
from hslam_bringup.errand_run import ErrandRun
from hslam_bringup.free_places import random_places
from hslam_ros.stamps import NS_PER_S
from hslam_types.se2 import SE2, wrap

_LIMIT_S = 3600.0
"""Simulated time after which the robot counts as still lost."""
_RIGHT_M, _RIGHT = 0.5, math.radians(20.0)
"""A place claimed farther from the true one, or turned more, is a wrong one."""


@dataclass(frozen=True)
class Localised:
    """How the starts ended; those that are neither right nor wrong were still in doubt at the time limit."""

    starts: int
    right: int
    wrong: int
    driven_m: float
    """Mean true way driven until the place was known."""

    @property
    def fields(self) -> dict[str, float]:
        """The fields of the report."""
        return asdict(self)


def localise(errand: Errand, starts: int, seed: int, show: Callable[[int, str], None]) -> Localised:
    """Wake the robot of an errand at so many random places; ``show(done, what)`` is called after each.

    Raises StoreError where the atlas cannot be read, RunError where it is of another world.
    """
    right = wrong = 0
    driven: list[float] = []
    with atlas_state(errand.atlas) as state:
        show(0, "comparing atlas and world")
        frames = true_edge_frames(errand.world, state.graph, state.maps)
        for count, place in enumerate(random_places(errand.world, starts, np.random.default_rng(seed)), 1):
            mission = Localise(state)
            woken = dataclasses.replace(errand.world, start=place)
            run = ErrandRun(woken, seed + count, errand.settings, mission)
            while run.simulation.stamp_ns < _LIMIT_S * NS_PER_S and not run.step():
                pass
            claimed = claimed_in_world(state, mission, run, frames)
            if claimed is not None:
                is_right = math.dist(claimed[:2], run.truth[:2]) < _RIGHT_M
                is_right &= abs(wrap(claimed.theta - run.truth.theta)) < _RIGHT
                right, wrong = right + is_right, wrong + (not is_right)
                driven.append(run.driven_m)
            show(count, f"{right} right, {wrong} wrong, {count - right - wrong} in doubt, {_mean(driven):.0f} m each")
    return Localised(starts, right, wrong, _mean(driven))


def claimed_in_world(state: AtlasState, mission: Localise, run: ErrandRun, frames: dict[int, SE2]) -> SE2 | None:
    """Return where the robot says it is, by the true frame of an edge at its node; None while it says nothing."""
    place = mission.place
    base_in_node = None if place is None else place.base_in_node(run.sense)
    if place is None or base_in_node is None:
        return None
    for branch in state.graph.nodes[place.node].ordered():
        if branch.edge in frames:
            edge = state.graph.edges[branch.edge]
            end = edge.end_at(place.node, branch.key)
            origin = SE2() if end == 0 else SE2(edge.terminal_x, 0.0, math.pi)
            node_in_world = frames[edge.id] @ origin @ edge.ends[end].frame_in_node.pose.inverse()
            return node_in_world @ base_in_node
    return None


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else 0.0
