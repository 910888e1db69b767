"""One search over states at rest: arcs, caging descents and motion primitives, each executed by
perturbed samples before anything is built upon it.
"""
