"""Panels: layout only. What they do is in operators, what they show in properties and records."""
