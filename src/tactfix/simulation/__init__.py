"""Simulated contacts of a probe, with noise and with mistakes."""
