"""`penumbra compare-reports`: what changed from one report to another, of two machines or two versions.

read.py takes report.json in and refuses what it cannot trust, match.py finds the pairs and judges them (pure), text.py
and page.py say it.
"""
