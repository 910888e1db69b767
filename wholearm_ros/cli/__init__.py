"""The command line `wholearm`."""
