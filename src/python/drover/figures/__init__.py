"""drover/figures: figures of archives and results, and the panels of which they are made."""
