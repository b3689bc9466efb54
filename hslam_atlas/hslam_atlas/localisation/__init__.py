"""Where the robot is in an atlas that is only read."""
