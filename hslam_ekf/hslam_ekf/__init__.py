"""Odometry and landmarks to edge-maps: one small EKF map along each edge of the graph."""
