"""The second look: local patterns, people lit as the photograph is, moved where it shows them, and why."""
