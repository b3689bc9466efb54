"""Bags: recording runs to rosbag2 directories of MCAP files, reading, repairing and replaying them."""
