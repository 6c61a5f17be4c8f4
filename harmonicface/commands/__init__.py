"""What the commands of the command line do: one file for the commands that belong together."""
