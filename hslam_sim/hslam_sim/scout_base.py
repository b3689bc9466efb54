"""The simulated base: wheels that need time to change speed, odometry that drifts, walls that stop it."""

import math

import numpy as np

from hslam_sim.base_configuration import BaseConfiguration
from hslam_sim.wall_index import WallIndex
from hslam_types.se2 import SE2, wrap
from hslam_types.sensing import Velocity

SUBSTEP_S = 0.03
"""Integration step; a chord this short is an arc to a few micrometres at the Scout's speeds."""


class ScoutBase:
    """True pose in map and encoder pose in odom, moved together one simulation step at a time."""

    def __init__(
        self, start: SE2, walls: WallIndex, config: BaseConfiguration, bias_rng: np.random.Generator,
        slip_rng: np.random.Generator,
    ) -> None:  # fmt: skip
        """Start at rest at a pose of base_link in map; the rotation bias is drawn at once."""
        self._walls, self._config, self._rng = walls, config, slip_rng
        self.true_pose, self.encoder_pose = start, SE2()
        size = config.bias_least + float(bias_rng.random()) * (config.bias_most - config.bias_least)
        self.rotation_bias = size if bias_rng.random() < 0.5 else -size
        """True heading gained a metre driven beyond what the encoders tell (rad/m)."""
        self.contacts = 0
        """How often the body has met a wall."""
        self.touching = False
        """Whether a wall stopped the body during the last step."""
        self.travelled_m = 0.0
        """True distance driven."""
        self.odometer_m = 0.0
        """Distance the wheels have turned, as the encoders tell it."""
        self._right = self._left = 0.0
        self._wanted = Velocity()
        self._silence_s = math.inf
        self._room_m = -1.0
        self._track: list[tuple[float, SE2]] = [(0.0, start)]

    @property
    def velocity(self) -> Velocity:
        """The velocity the encoders measure now."""
        return Velocity(0.5 * (self._right + self._left), (self._right - self._left) / self._config.wheel_base_m)

    def step(self, command: Velocity | None, duration_s: float) -> None:
        """Move for ``duration_s``; None means that no new command has come and the last one still holds."""
        if command is not None:
            self._wanted, self._silence_s = command, 0.0
        touched_before, self.touching = self.touching, False
        count = max(1, round(duration_s / SUBSTEP_S))
        scale, turn_scale, walk = self._slip(count)
        dt = duration_s / count
        self._track = [(0.0, self.true_pose)]
        for i in range(1, count + 1):
            self._advance(dt, scale, turn_scale, walk)
            self._track.append((i * dt, self.true_pose))
        if self.touching and not touched_before:
            self.contacts += 1

    def true_pose_at(self, offset_s: float) -> SE2:
        """Return the true pose ``offset_s`` after the beginning of the last step, between its ends."""
        later = next((i for i, (when, _) in enumerate(self._track) if when >= offset_s - 1e-9), len(self._track) - 1)
        (t1, b), (t0, a) = self._track[later], self._track[max(later - 1, 0)]
        if t1 - offset_s < 1e-9 or later == 0:
            return b
        share = (offset_s - t0) / (t1 - t0)
        turn = wrap(b.theta - a.theta)
        return SE2(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), wrap(a.theta + share * turn))

    def _slip(self, count: int) -> tuple[float, float, float]:
        """Draw the step's errors: factors on length and turn, and a substep's heading walk (rad/sqrt(m))."""
        config = self._config
        length, turn, walk = self._rng.standard_normal(3).tolist()
        # One draw serves the whole step, so its share must add up over the substeps, not average out.
        per_substep = config.heading_walk * walk / math.sqrt(count)
        return 1.0 + config.slip_fraction * length, 1.0 + config.turn_slip_fraction * turn, per_substep

    def _advance(self, dt: float, scale: float, turn_scale: float, walk: float) -> None:
        self._drive_wheels(dt)
        forward, turn = self.velocity
        length, angle = forward * dt, turn * dt
        driven = abs(length)
        drift = self.rotation_bias * driven + walk * math.sqrt(driven)
        moved = _arc(self.true_pose, length * scale, angle * turn_scale + drift)
        if self._blocked(moved):
            self.touching = True
            # The body is held and so are the wheels; turning on the spot stays possible.
            spin = 0.5 * (self._right - self._left)
            self._right, self._left, length = spin, -spin, 0.0
            moved = _arc(self.true_pose, 0.0, angle * turn_scale)
        self.travelled_m += math.hypot(moved.x - self.true_pose.x, moved.y - self.true_pose.y)
        self.true_pose = moved
        self.odometer_m += abs(length)
        self.encoder_pose = _arc(self.encoder_pose, length, angle)

    def _drive_wheels(self, dt: float) -> None:
        config = self._config
        self._silence_s += dt
        forward, turn = self._wanted if self._silence_s <= config.command_timeout_s + 1e-9 else Velocity()
        spin, limit, change = 0.5 * turn * config.wheel_base_m, config.wheel_speed_limit, config.wheel_acceleration * dt
        right, left = min(max(forward + spin, -limit), limit), min(max(forward - spin, -limit), limit)
        self._right += min(max(right - self._right, -change), change)
        self._left += min(max(left - self._left, -change), change)

    def _blocked(self, moved: SE2) -> bool:
        """Whether the body would enter a wall; moving away from a wall it touches is allowed."""
        here = self.true_pose
        self._room_m -= math.hypot(moved.x - here.x, moved.y - here.y)
        if self._room_m > 0.0:
            return False
        near = self._walls.near(moved.x, moved.y)
        clearance = near.clearance(moved.x, moved.y)
        self._room_m = clearance - self._config.body_radius_m
        return self._room_m < 0.0 and clearance < near.clearance(here.x, here.y)


def _arc(pose: SE2, length: float, angle: float) -> SE2:
    """Return the pose after an arc, by its chord at half the turn."""
    middle = pose.theta + 0.5 * angle
    return SE2(pose.x + length * math.cos(middle), pose.y + length * math.sin(middle), wrap(pose.theta + angle))
