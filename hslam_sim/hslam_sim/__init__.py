"""Worlds, the Scout base, its sonar and landmark sensor, and the truth to score a run against."""
