"""The suite's root exception; each package derives its own from it."""


class HslamError(Exception):
    """Base of every error the suite raises on purpose; its text is one line that says what to do."""


class ConfigurationError(HslamError):
    """A parameter is unknown, of the wrong type or out of its range."""


class MessageError(HslamError):
    """A message contradicts itself or holds what is no number: nothing of it can be used. The text names the field."""
