"""`python -m wholearm_ros` is the command line."""
from .cli import main

main()
