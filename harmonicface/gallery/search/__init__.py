"""Exact search among many people without reading all of their pixels."""
