"""Penumbra: classic soft-shadow techniques side by side on a Blender scene, with their error and their cost.

The package knows Blender and makes no pixels; those come from the compiled module `penumbra_core`. It is an extension
of Blender (`register`), a command line (`penumbra`), and a library.
"""

__version__ = "0.1.0"


def register() -> None:
    """Called by Blender when the extension is switched on."""
    from . import registration

    registration.register()


def unregister() -> None:
    from . import registration

    registration.unregister()
