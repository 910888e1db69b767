"""Figures of a plan and a run, as files."""
