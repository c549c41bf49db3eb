"""IR to freestanding C99: generator, build and loader, and the program that Python runs."""
