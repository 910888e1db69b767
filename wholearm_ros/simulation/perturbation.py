"""Moved to model/perturbation.py, where trajectory/verify.py may import it too; this name stays for a moment."""
from ..model.perturbation import NOMINAL, Perturbation, draw_perturbation  # noqa: F401
