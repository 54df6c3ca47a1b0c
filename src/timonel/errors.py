"""Every error that timonel raises at its own caller.

What a peer sends wrong is never one of these: it is a `Rejected` or `Refused` effect (see `core.effects`).
"""


class TimonelError(Exception):
    """Base of all errors of this package."""


class DecodeError(TimonelError):
    """Bytes handed to a decoder by our own caller are not a message of that kind."""


class EncodeError(TimonelError):
    """A value does not fit the field it was given for; the text names field, value and range."""


class ConfigError(TimonelError):
    """A configuration that cannot be run; the text has one line for each mistake."""


class LinkError(TimonelError):
    """A link that cannot be opened as it was asked for (a bad URL, a missing extra)."""


class RecordingError(TimonelError):
    """A recording that cannot be read; the text names file and line."""


class StationError(TimonelError):
    """What the far end of a station's wire did not do."""


class RefusedError(StationError):
    """The gateway refused a command of this station."""


class NoAnswerError(StationError):
    """The gateway did not answer within the time allowed."""
