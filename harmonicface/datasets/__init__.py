"""Readers of public data sets and their protocols."""
