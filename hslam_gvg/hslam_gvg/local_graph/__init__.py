"""The reduced GVG round the robot, by the rules that also define the truth."""
