"""A robot sent to random places of a known atlas, scored against the simulator's truth."""

import math
from collections.abc import Callable, Collection
from dataclasses import asdict, dataclass

import numpy as np

from hslam_atlas.missions.destination import AtNode, Destination, OnEdge, beside
from hslam_atlas.missions.navigate import Navigate, Progress
from hslam_bringup.atlas_truth import true_edge_frames
from hslam_bringup.errand import Errand, atlas_state
from hslam_bringup.errand_run import ErrandRun
from hslam_bringup.free_places import ShortestWays, random_places
from hslam_ros.stamps import NS_PER_S
from hslam_types.se2 import SE2

_LIMIT_S = 3600.0
"""Simulated time after which an errand is given up."""


@dataclass(frozen=True)
class Navigated:
    """How the errands ended."""

    goals: int
    reached: int
    error_m_max: float | None
    """Of those reached: the robot's true place from the true place of the goal; None without one."""
    driven_over_shortest: float | None
    """Way driven to those reached over the shortest way of the body through the floor."""

    @property
    def fields(self) -> dict[str, float | None]:
        """The fields of the report."""
        return asdict(self)


def navigate(errand: Errand, goals: int, seed: int, show: Callable[[int, str], None]) -> Navigated:
    """Send the robot of an errand to so many random places; ``show(done, what)`` is called after each.

    Raises StoreError where the atlas cannot be read, RunError where it is of another world.
    """
    with atlas_state(errand.atlas) as state:
        show(0, "comparing atlas and world")
        frames = true_edge_frames(errand.world, state.graph, state.maps)
        places = random_places(errand.world, goals, np.random.default_rng(seed))
        shortest = ShortestWays(errand.world, errand.body_radius_m)
        mission = Navigate(state)
        run = ErrandRun(errand.world, seed, errand.settings, mission)
        errors: list[float] = []
        driven_m = shortest_m = 0.0
        show(0, "finding itself")
        _find_itself(run, mission, state.graph.nodes)
        for count, place in enumerate(places, 1):
            start, before_m = run.truth, run.driven_m
            goal = beside(state.graph, state.maps, frames, place.x, place.y)
            if go(run, mission, goal):
                errors.append(_error_m(run.truth, goal, frames))
                driven_m += run.driven_m - before_m
                shortest_m += shortest.length_m(start, place)
            else:
                show(count, f"goal {count}, {goal}: {mission.progress.value}: {mission.why}")
            show(count, f"{len(errors)} reached, {max(errors, default=0.0):.2f} m off at most")
    ratio = driven_m / shortest_m if shortest_m else None
    return Navigated(goals, len(errors), max(errors, default=None), ratio)


def go(run: ErrandRun, mission: Navigate, destination: Destination) -> bool:
    """Drive to one destination; return whether it was reached within the time limit."""
    mission.go_to(destination)
    until_ns = run.simulation.stamp_ns + _LIMIT_S * NS_PER_S
    while run.simulation.stamp_ns < until_ns:
        if run.step():
            break
    return mission.progress is Progress.REACHED


def _find_itself(run: ErrandRun, mission: Navigate, nodes: Collection[int]) -> None:
    """Go to the node the robot knows first, wherever that is: no errand counts before it knows where it is."""
    mission.go_to(AtNode(min(nodes)))
    until_ns = run.simulation.stamp_ns + _LIMIT_S * NS_PER_S
    while mission.place is None and run.simulation.stamp_ns < until_ns:
        run.step()


def _error_m(truth: SE2, goal: OnEdge, frames: dict[int, SE2]) -> float:
    return math.dist(truth[:2], frames[goal.edge].apply(goal.distance, goal.offset))
