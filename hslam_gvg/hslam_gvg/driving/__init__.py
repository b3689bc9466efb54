"""What the robot does: set out, follow an edge, home on a node, find its way out of trouble."""
