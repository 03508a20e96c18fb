"""`penumbra stability`: every technique on cases that are hard on numbers, each with what must hold and how well.

The cases are data (cases.py) over scenes made of numpy arrays (setups.py, shapes.py); what must hold are functions of
images (properties.py); how well, where a method is wrong by construction, is data again, with its source (limits.py).
Blender has no part in it.
"""
