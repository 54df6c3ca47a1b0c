"""Where decoded recordings go: JSON lines, CSV, Arrow, Parquet."""
