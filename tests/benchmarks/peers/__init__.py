"""The parts of tests/benchmarks/peers.py: scenes, one file per renderer, measuring, curves, page."""
