"""Independent NumPy implementations that the Rust results are compared with."""
