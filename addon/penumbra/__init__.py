"""Penumbra: classic soft-shadow techniques side by side on a Blender scene, with their error and their cost.

The package knows Blender and makes no pixels; those come from the compiled module `penumbra_core`.
"""

__version__ = "0.1.0"
