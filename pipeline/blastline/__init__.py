"""Find the gunshots of a film's soundtrack and render an aligned vibration drive for 4D cinema."""

__version__ = "0.1.0"
