"""Comparing within Blender: in the background, with results that stay in the file.

running.py works on a thread and knows nothing of Blender; operators.py reads the scene, starts it, and collects what it
found; results.py keeps that in the scene, pictures.py beside it.
"""
