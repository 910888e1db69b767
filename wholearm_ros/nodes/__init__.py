"""One file an executable; each is parameters, core object, channels, timers."""
