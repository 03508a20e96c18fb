"""Pictures in 3D viewports: the render engine's own, and the overlay on top of any engine."""
