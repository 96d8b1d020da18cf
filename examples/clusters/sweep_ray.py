"""A sweep on a Ray cluster: python sweep_ray.py SHARDS OUT ARGUMENTS OF `sandbox sweep`...

OUT is a folder that every machine sees. A task that dies is tried again, and continues after its last run.
"""

import subprocess
import sys
import time

import ray


@ray.remote(num_cpus=1, max_retries=5, retry_exceptions=True)
def run_shard(number, of, out, arguments):
    command = ["sandbox", "sweep", *arguments, "--threads", "1", "--resume"]
    command += ["--shard", f"{number}/{of}", "--out", f"{out}/{number}"]
    while True:
        done = subprocess.run(command, capture_output=True, text=True)
        if "another study writes into this folder" not in done.stderr:
            break
        time.sleep(1.0)  # the program of a task that died runs on: wait for it
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return f"{out}/{number}"


def main():
    shards, out, arguments = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    ray.init(log_to_driver=False)
    waiting = [run_shard.remote(number, shards, out, arguments) for number in range(1, shards + 1)]
    folders = []
    while waiting:
        ready, waiting = ray.wait(waiting)
        folders += ray.get(ready)
        print(f"{len(folders)} of {shards} shards", flush=True)
    subprocess.run(["sandbox", "merge", *folders, "--out", f"{out}/all"], check=True)


if __name__ == "__main__":
    main()
