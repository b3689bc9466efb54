"""Puts the suite together: the `hslam` command, whole runs in one process or many, launch files."""
