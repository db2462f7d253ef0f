"""One self-contained HTML page about a results folder."""
