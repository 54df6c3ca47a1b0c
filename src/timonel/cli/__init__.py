import os

# NumPy would start threads for linear algebra, of which there is none here: they are a good part of its start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
