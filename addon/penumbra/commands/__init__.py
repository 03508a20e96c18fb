"""The subcommands of `penumbra`, one module per kind of work. What all share: registry.py, arguments.py, scene.py."""
