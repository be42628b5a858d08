"""Schemas of the registry, one after the other, and how one becomes the next."""
