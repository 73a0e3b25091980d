"""Displays for notebooks and browsers: players and tables in HTML, the moving picture, and the live page."""
