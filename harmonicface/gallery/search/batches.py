"""Many photographs at once: the search of `cascade` under the name that its callers know."""

from harmonicface.gallery.search.cascade import search_many

__all__ = ["search_many"]
