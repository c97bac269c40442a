"""A Dask cluster of two worker processes on this machine. Prints its address; each line "kill" kills one worker.

Started by the tests as a process of its own, so that what a cluster does to signals, warnings and threads stays there.
"""

import os
import signal
import sys

from distributed import LocalCluster

WORKERS = 2


def main() -> None:
    with LocalCluster(n_workers=WORKERS, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        for line in sys.stdin:
            if line.strip() == "kill":
                nanny = next(iter(cluster.workers.values()))
                os.kill(nanny.pid, signal.SIGKILL)
                print(nanny.pid, flush=True)


if __name__ == "__main__":
    main()
