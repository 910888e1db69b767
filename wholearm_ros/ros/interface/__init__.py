"""Names, messages, parameters: what the graph agrees on."""
