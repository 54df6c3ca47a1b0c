"""Where a server listens, as people write it: "127.0.0.1:8080", "[::]:8080", "boat.local:8080"."""

import ipaddress


def place(text: str) -> tuple[str, int]:
    """Host and port; raises ValueError that says what would be right."""
    host, _, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]") if host.startswith("[") else host
    if not host or not port.isdecimal() or int(port) > 65535 or (":" in host and not text.startswith("[")):
        raise ValueError(f'"{text}" should be a host and a port, like "127.0.0.1:8080" or "[::1]:8080"')
    return host, int(port)


def is_loopback(host: str) -> bool:
    """Whether only this computer reaches it."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
