"""What a recording can be asked for: the parameters of `record_node`, beside those of `RecorderConfig`."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class RecordConfiguration(Configuration):
    """What is recorded, and where to."""

    path: str = parameter("", "folder of the bag, new or empty")
    topics: str = parameter("", "names or regular expressions of the topics, by commas; empty: all")
    exclude: str = parameter("/parameter_events", "names or regular expressions of topics left out, by commas")
    hidden: bool = parameter(False, "record hidden topics too, such as those of actions")
    times: str = parameter(
        "stamp", "a message's time is its 'stamp', else the newest stamp heard; or when it was 'received'"
    )
    require: str = parameter(
        "", "topics, by commas; once all are heard, ~/status says so to whoever waits with the first step"
    )
    find_every_s: float = parameter(0.25, "wall time between two looks for new topics", low=0.01, high=60.0, unit="s")
    flush_every_s: float = parameter(
        1.0, "wall time after which what was received is on disk", low=0.05, high=60.0, unit="s"
    )
