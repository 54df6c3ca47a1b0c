import os

# NumPy would start threads for linear algebra, of which there is none here: they are a good part of its start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Arrow's own allocator keeps tens of MiB that it does not need any more.
os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
