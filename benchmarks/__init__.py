"""How fast it is, beside others that do the same: `python -m benchmarks.live` and `python -m benchmarks.codec`."""
