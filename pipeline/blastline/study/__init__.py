"""Measuring: training the verifier, and what speed and accuracy a setting has on scenes with a known truth."""
