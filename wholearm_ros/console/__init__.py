"""The bench console: a page in the browser that shows the hand live and commands it."""
