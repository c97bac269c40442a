"""A Dask cluster of two worker processes on this machine. Prints its address; each line "kill" kills one worker.

The tests start it as a separate process, so that the cluster does not affect their signals, warnings and threads.
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
