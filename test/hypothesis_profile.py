"""Pytest plugin: hypothesis tries the same examples every time, and may take its time on a loaded machine."""

from hypothesis import HealthCheck, settings

# Hypothesis' own profile "ci", by another name: that of Ubuntu 24.04 (6.98) does not have it.
settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")
