"""Shared by all rooms: checked arguments, files, Ctrl-C, optional packages. Imports nothing itself."""
