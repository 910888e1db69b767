"""Frozen nouns: what a task, a contact state, a plan and a trajectory are."""
