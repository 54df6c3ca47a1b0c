"""The compiled kernels, where there are any: without them everything works, and decoding takes twice as long.

They are used as `native.kernels`, which is None without them, or with `TIMONEL_PURE=1` in the environment.
"""

from os import environ

try:
    if environ.get("TIMONEL_PURE"):
        raise ImportError
    import timonel._native as kernels
except ImportError:
    kernels = None  # type: ignore[assignment]

__all__ = ["kernels"]
