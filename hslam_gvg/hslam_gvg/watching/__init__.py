"""Telling the nodes and edges that a robot passes whom somebody else drives."""
