"""Voronoi graphs and the rules that reduce them to the GVG: one home for what the robot and the truth must agree on."""
