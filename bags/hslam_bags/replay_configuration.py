"""What a replay can be asked for: the parameters of `replay_node`."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class ReplayConfiguration(Configuration):
    """What is replayed, and how its time passes."""

    path: str = parameter("", "the bag: a folder, or a .mcap or .db3 file")
    topics: str = parameter("", "names or regular expressions of the topics, by commas; empty: all")
    exclude: str = parameter(
        "/rosout,/events/.*_split",
        "names or regular expressions of topics left out, by commas; by default a log and ros2 bag's own events",
    )
    live: str = parameter(
        "", "nodes that run now, by commas: what they said then is left out, lock-step waits for them"
    )
    lockstep: bool = parameter(
        False, "publish a cycle when the live nodes have answered the one before; else at 'rate'"
    )
    cycle_topic: str = parameter("/odom", "lock-step: the topic whose stamps are the cycles")
    rate: float = parameter(1.0, "bag time by wall time", low=0.001, high=1000.0)
    start_s: float = parameter(0.0, "where to begin, from the first message", low=0.0, unit="s")
    max_gap_s: float = parameter(
        60.0, "at a rate: a longer time without a message is passed over, and told", low=0.1, unit="s"
    )
    paused: bool = parameter(False, "begin at rest, to be woken by ~/resume or ~/step")
    delay_s: float = parameter(1.0, "at a rate: wall time for subscribers to be found", low=0.0, high=60.0, unit="s")
    start_within_s: float = parameter(
        60.0, "lock-step: wall time for the answers to the first cycle", low=0.1, unit="s"
    )
    fail_after_s: float = parameter(10.0, "lock-step: wall time for the answers to a later cycle", low=0.1, unit="s")
