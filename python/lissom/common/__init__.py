"""What all rooms use: checked arguments, files, Ctrl-C, optional packages. Imports nothing itself."""
