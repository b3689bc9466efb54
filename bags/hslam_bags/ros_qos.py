"""Between a bag's QoS and rclpy's, and which QoS to subscribe with."""

from collections.abc import Sequence

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from hslam_bags.qos import INFINITE_NS, OfferedQos

UNTOLD_DEPTH = 1000
"""Depth of a replayed topic whose bag does not tell it: discovery carries no history, so recorders rarely know."""


def offer_from_profile(profile: QoSProfile) -> OfferedQos:
    """Return what a publisher offers, as a bag stores it."""
    return OfferedQos(
        history=profile.history.name.lower(),
        depth=profile.depth,
        reliability=profile.reliability.name.lower(),
        durability=profile.durability.name.lower(),
        deadline_ns=_limit(profile.deadline),
        lifespan_ns=_limit(profile.lifespan),
        liveliness=profile.liveliness.name.lower(),
        lease_ns=_limit(profile.liveliness_lease_duration),
    )


def profile_from_offers(offers: Sequence[OfferedQos]) -> QoSProfile:
    """Return the profile to replay a topic with: the strongest offer, which every former subscriber accepts.

    Deadline, lifespan and lease are left out: a replay that is paused or hurried would break them.
    """
    reliable = not offers or any(offer.reliability != "best_effort" for offer in offers)
    latched = any(offer.durability == "transient_local" for offer in offers)
    depths = [offer.depth for offer in offers if offer.history == "keep_last" and offer.depth > 0]
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=max(depths, default=UNTOLD_DEPTH),
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        liveliness=LivelinessPolicy.AUTOMATIC,
    )


def recording_profile(offers: Sequence[OfferedQos]) -> QoSProfile:
    """Return the strongest profile that every publisher of a topic can serve, with unlimited history."""
    reliable = all(offer.reliability == "reliable" for offer in offers)
    latched = reliable and all(offer.durability == "transient_local" for offer in offers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def _limit(duration: Duration) -> int:
    """Return a duration in nanoseconds; rmw says "none" as 0 or as the largest."""
    nanoseconds = int(duration.nanoseconds)
    return nanoseconds if 0 < nanoseconds < INFINITE_NS else INFINITE_NS
