//! A simulated test bench.
