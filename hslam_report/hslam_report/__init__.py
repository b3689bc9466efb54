"""Scores and figures of a finished run; the only part besides the simulator that may read the truth."""
