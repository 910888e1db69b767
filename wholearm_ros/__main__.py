"""`python -m wholearm_ros` is the command line."""

from wholearm_ros.cli.main import main

main()
