"""Moved to mechanics/settled_start.py, where trajectory/verify.py may import it too; this name stays for a moment."""
from ..mechanics.settled_start import settled_start  # noqa: F401
