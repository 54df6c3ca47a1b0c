"""What the recorder needs that may not be installed."""

from importlib.util import find_spec

from timonel.errors import RecordingError

RECORDER = ("mcap", "zstandard")


def recorder_installed() -> bool:
    """Whether recordings can be written and read."""
    return all(map(find_spec, RECORDER))


def need_recorder() -> None:
    """Raises RecordingError that says what to install."""
    if not recorder_installed():
        raise RecordingError("recordings need mcap and zstandard: pip install timonel[recording]")


def mqtt_installed() -> bool:
    """Whether an MQTT broker can be told."""
    return find_spec("aiomqtt") is not None


def mdns_installed() -> bool:
    """Whether services can be told of on the local network."""
    return all(map(find_spec, ("zeroconf", "ifaddr")))


def web_installed() -> bool:
    """Whether the console can be served."""
    return all(map(find_spec, ("starlette", "uvicorn", "websockets")))
