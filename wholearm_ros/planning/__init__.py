"""Phase 1: the search for contact-state transitions."""
