"""Phase 2: from a contact plan to what both fingers do over time."""
