"""What the finger angles say about the object: where it lies after a run, and whether it keeps to
the plan.
"""
