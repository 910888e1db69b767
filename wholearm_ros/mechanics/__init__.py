"""Mechanics of a polygon between two fingers and a palm: contacts, quasi-statics (1)–(5), torque
range (6), dynamics, caging.
"""
