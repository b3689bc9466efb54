"""Values that cross package borders: poses, sensor readings, GVG events, edge-maps, configuration."""
