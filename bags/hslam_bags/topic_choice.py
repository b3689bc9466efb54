"""Which topics to record or replay."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hslam_types.errors import ConfigurationError


@dataclass(frozen=True)
class TopicChoice:
    """Topics by name or regular expression, which must match the whole name; none chosen: all of them."""

    include: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()
    hidden: bool = False
    """Also topics with a part that begins with an underscore, such as those of actions."""

    def __post_init__(self) -> None:
        """Check the expressions; raises ConfigurationError."""
        for pattern in (*self.include, *self.exclude):
            try:
                re.compile(pattern)
            except re.error as error:
                raise ConfigurationError(f"'{pattern}' is neither a topic nor a regular expression: {error}") from error

    def __contains__(self, topic: str) -> bool:
        """Return whether ``topic``, a full name, is chosen; naming a hidden topic chooses it."""
        if _any_matches(self.exclude, topic):
            return False
        if self.include:
            return _any_matches(self.include, topic)
        return self.hidden or "/_" not in topic


def names(text: str) -> tuple[str, ...]:
    """Split a parameter's list of topics, separated by commas."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def _any_matches(patterns: Sequence[str], topic: str) -> bool:
    """Return whether a pattern matches the whole name; a name without its leading slash means the same topic."""
    return any(re.fullmatch(pattern, topic) or re.fullmatch("/" + pattern, topic) for pattern in patterns)
