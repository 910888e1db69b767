"""Starts, watches and stops the graph of nodes, as a client of it."""
