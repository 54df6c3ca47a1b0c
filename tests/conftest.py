"""What all tests share."""

import pytest
from hypothesis import settings

from timonel import native

settings.register_profile("unhurried", deadline=None)  # a busy machine is no fault of what is tested
settings.load_profile("unhurried")


@pytest.fixture(params=["compiled", "interpreted"])
def each_way(request, monkeypatch):
    """Once with the compiled kernels, once without. They need a C compiler and Python's headers to be there."""
    if request.param == "interpreted":
        monkeypatch.setattr(native, "kernels", None)
    else:
        assert native.kernels is not None, "not compiled: python3 hatch_build.py says why"
