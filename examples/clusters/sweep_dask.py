"""A sweep on a Dask cluster: python sweep_dask.py SCHEDULER SHARDS OUT ARGUMENTS OF `sandbox sweep`...

OUT is a folder that every machine sees. A task whose worker dies is tried again, and continues after its last run.
"""

import subprocess
import sys

from dask.distributed import Client, as_completed


def run_shard(number, of, out, arguments):
    command = ["sandbox", "sweep", *arguments, "--threads", "1", "--resume"]
    command += ["--shard", f"{number}/{of}", "--out", f"{out}/{number}"]
    subprocess.run(command, check=True)
    return f"{out}/{number}"


if __name__ == "__main__":
    client, shards, out, arguments = Client(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4:]
    tasks = [
        client.submit(run_shard, number, shards, out, arguments, retries=5) for number in range(1, shards + 1)
    ]
    folders = [task.result() for task in as_completed(tasks)]
    subprocess.run(["sandbox", "merge", *folders, "--out", f"{out}/all"], check=True)
