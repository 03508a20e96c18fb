"""Readers of Blender's data that make plain numbers of it; only `bridge` hands these to the core."""
