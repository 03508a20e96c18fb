"""What keeps a Blender scene from being read."""


class BridgeError(Exception):
    """Something of the Blender scene cannot be exported at all; one sentence."""
