"""What the atlas can be told: how well places repeat, what counts as evidence, when a loop may be closed."""

import math
from dataclasses import dataclass

from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError

MISSIONS = ("explore", "localise", "none")


@dataclass(frozen=True)
class AtlasConfig(Configuration):
    """Parameters of the atlas; standard deviations unless said otherwise, evidence in nats (natural logarithms)."""

    mission: str = parameter(
        "explore",
        "'explore' drives until no edge is unexplored, in an atlas taken up once the robot is found; "
        "'localise' finds the robot and changes nothing; 'none' only maps what is driven.",
        changeable=True,
    )
    return_home: bool = parameter(
        False, "After exploring, go back to the oldest node; failing to is a warning.", changeable=True
    )
    localise_drives: int = parameter(
        20, "Drives from node to node after which a robot that is not found is given up.", low=1, high=1000
    )
    origin_repeat_m: float = parameter(
        0.06, "Repeatability of a meet point between visits.", low=0.001, high=1.0, unit="m"
    )
    boundary_repeat_m: float = parameter(
        0.3, "Repeatability of a boundary point between visits.", low=0.001, high=2.0, unit="m"
    )
    bearing_repeat: float = parameter(
        math.radians(5.0), "Repeatability of a branch's bearing between visits.", low=0.001, high=1.0, unit="rad"
    )
    heading_floor: float = parameter(
        math.radians(0.5),
        "Heading error of an edge frame beyond what the filter admits.",
        low=0.0,
        high=1.0,
        unit="rad",
    )
    lost_per_metre: float = parameter(
        0.15, "Error of a pose by bare odometry where the robot was lost, for each metre.", low=0.0, high=10.0
    )
    chain_inflation: float = parameter(
        1.5, "Factor on the standard deviation of chained poses: filters are optimistic.", low=1.0, high=10.0
    )
    pose_gate: float = parameter(
        16.0, "Chi (2 degrees of freedom) beyond which a node cannot be the one arrived at.", low=1.0, high=100.0
    )
    pair_noise_m: float = parameter(
        0.03, "Error of a landmark between two maps beyond their covariances.", low=0.001, high=1.0, unit="m"
    )
    pair_gate: float = parameter(
        9.2, "Chi of an accepted pair of landmarks (2 degrees of freedom).", low=1.0, high=50.0
    )
    near_m: float = parameter(
        5.0, "Landmarks within this of a node are its constellation.", low=1.0, high=50.0, unit="m"
    )
    visible_near: float = parameter(
        0.75, "Probability that a landmark of a constellation is in another map of it.", low=0.01, high=0.99
    )
    visible_edge: float = parameter(
        0.85, "Probability that a landmark of an edge is in another map of it.", low=0.01, high=0.99
    )
    least_fraction: float = parameter(
        0.5, "Fraction of the landmarks that must associate, both ways, for maps to match.", low=0.0, high=1.0
    )
    map_distance: float = parameter(
        2.5, "Largest eq. 8 distance a degree of freedom of matching maps.", low=1.0, high=20.0
    )
    repetition: float = parameter(
        1e-4, "Probability that a different place looks the same, before any such was met.", low=1e-12, high=0.5
    )
    node_density: float = parameter(
        0.004, "Nodes expected per square metre, the rival of a pose that fits.", low=1e-6, high=1.0, unit="1/m^2"
    )
    close_evidence: float = parameter(9.0, "Evidence at which a loop may close.", low=0.0, high=100.0)
    close_margin: float = parameter(
        5.0, "Lead over the next hypothesis at which a loop may close.", low=0.0, high=100.0
    )
    keep_evidence: float = parameter(-3.0, "Evidence below which a hypothesis is dropped.", low=-100.0, high=0.0)
    confirm_evidence: float = parameter(
        -3.0, "Evidence from which an open question is worth a drive that would confirm it.", low=-100.0, high=100.0
    )
    branch_gate: float = parameter(
        math.radians(40.0), "Two bearings farther apart are different branches.", low=0.05, high=1.6, unit="rad"
    )
    length_tolerance: float = parameter(0.06, "Relative difference of two drives along one edge.", low=0.001, high=0.5)
    length_tolerance_m: float = parameter(
        1.2, "Absolute difference of two drives along one edge.", low=0.01, high=10.0, unit="m"
    )
    forget_below: int = parameter(
        4,
        "A landmark that a later drive along its edge does not see keeps a third of its sightings, "
        "and goes when fewer than this are left.",
        low=1,
        high=1000,
    )
    goal_tolerance_m: float = parameter(
        0.12, "An errand to a point has reached it within this distance.", low=0.01, high=2.0, unit="m"
    )
    drive_twice: bool = parameter(
        False,
        "Exploring ends only when every edge was driven twice: a junction passed unnoticed is then seldom missed, "
        "for a longer tour.",
    )
    attempts: int = parameter(3, "Fruitless drives after which a branch is given up.", low=1, high=100)

    def __post_init__(self) -> None:
        """Check the mission too."""
        super().__post_init__()
        if self.mission not in MISSIONS:
            raise ConfigurationError(f"parameter 'mission' must be one of {', '.join(MISSIONS)}, not '{self.mission}'")
