"""A robot in a simulated world that uses an atlas instead of making one: the levels stepped in this process."""

import math
from collections.abc import Mapping
from typing import Any

from hslam_atlas.missions.mission import Happened, Mission, Sense
from hslam_bringup.simulated_robot import simulation_configuration
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_gvg.level import SCAN, level_from_mapping
from hslam_gvg.states import GvgError, GvgState
from hslam_ros import conversions
from hslam_sim.simulation import Simulation
from hslam_sim.world import World
from hslam_types.sensing import Velocity


class ErrandRun:
    """Steps base, GVG level and EKF level, and the mission in the place of the atlas level."""

    def __init__(self, world: World, seed: int, settings: Mapping[str, Mapping[str, Any]], mission: Mission) -> None:
        """Put the robot at the world's start; ``settings`` by node and parameter, over the defaults."""
        config = simulation_configuration(settings.get("sim", {}))
        self.simulation, self.mission = Simulation(world, config, seed), mission
        self._gvg, self._source = level_from_mapping(settings.get("gvg", {}))
        self._ekf = EkfServer(EkfConfig.from_mapping(settings.get("ekf", {})))
        self._command: Velocity | None = None
        self.truth = world.start
        """Where the robot truly is: for scoring alone."""
        self.driven_m = 0.0
        """True distance driven."""
        self.sense = Sense()
        """What the mission was last told."""
        self.contacts = 0

    def step(self) -> bool:
        """Do one cycle; return whether the mission has ended."""
        base = self.simulation.step(self._command)
        self.driven_m += math.dist(base.truth[:2], self.truth[:2])
        self.truth, self.contacts = base.truth, base.collisions
        odom = conversions.odometry_from_msg(conversions.odometry_to_msg(base.odom))
        driven = self._gvg.step(odom, base.scan if self._source.source == SCAN else base.sonar)
        mapped = self._ekf.step(odom, base.landmarks, driven.events)
        self.sense = Sense(
            odom.base_in_odom,
            mapped.traversal,
            mapped.base_in_edge,
            self._ekf.so_far,
            self._gvg.room_m,
            driven.state is GvgState.IDLE,
        )
        decided = self.mission.step(Happened(driven.events, mapped.edge_maps, mapped.links, self.sense))
        if decided.goal is not None:
            try:
                self._gvg.start(decided.goal, base.stamp_ns)
            except GvgError:
                self.mission.refused()
        self._command = driven.command
        return decided.finished
