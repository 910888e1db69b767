"""Perturbed samples of a task and their simulated runs."""
