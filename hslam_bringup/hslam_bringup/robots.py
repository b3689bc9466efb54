"""The robots that a run can drive, as the commands name them."""

from enum import StrEnum


class Robot(StrEnum):
    """Which base a run drives."""

    SIM = "sim"
    TURTLEBOT = "turtlebot"
    SCOUT = "scout"
