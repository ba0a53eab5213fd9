"""Independent NumPy implementations for comparison with the results of Rust."""
