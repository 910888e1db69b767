"""What the numbers of a scenario must satisfy among themselves: geometry and rest."""


def problems_with(table) -> list:
    """Every problem found, each as 'key: got ...; allowed: ...'."""
    return []
