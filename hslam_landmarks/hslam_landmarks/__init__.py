"""Landmarks out of a lidar's scans: corners and ends of walls, poles, reflectors."""
