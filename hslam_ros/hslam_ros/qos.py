"""The suite's quality-of-service profiles, by what they are for.

Everything that lock-step waits for is transient-local: a peer that is discovered late still gets the
few messages that are outstanding, so no start-up order can lose one.
"""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _reliable(depth: int) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


CYCLE = _reliable(16)
"""Sensor readings, commands and statuses in lock-step, and every publisher of them."""

EVENTS = _reliable(1000)
"""Events, edge-maps and links: the map is built from these, none may be lost."""

LATCHED = _reliable(1)
"""The newest picture of something: atlas, markers, local map."""

SENSOR = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=10,
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
)
"""Subscriptions to sensors outside lock-step: an old reading is worth nothing."""


def sensor_subscription(lockstep: bool) -> QoSProfile:
    """Return the profile to hear sensors with: lossless in lock-step, newest first otherwise."""
    return CYCLE if lockstep else SENSOR
