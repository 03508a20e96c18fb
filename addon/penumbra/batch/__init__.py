"""`penumbra batch`: many scenes and frames, by worker processes here or on a farm, resumable, with one summary.

jobs.py says what there is to do, store.py what is done already and where it lies, work.py does one item, worker.py is
the process that does one after another, local.py and dask_farm.py hand items to such processes, summary.py looks at
everything that is done. docs/decisions/0012-batch.md has the reasons.
"""
