"""Sonar to local obstacle map to control along the generalized Voronoi graph."""
