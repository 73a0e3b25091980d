"""What a notebook or browser shows: players and tables in HTML, the picture that turns, and the live page."""
