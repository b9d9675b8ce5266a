"""A parameter sweep on a Dask cluster: the same FMU on every worker.

`motor-fmu sweep` uses the cores of one machine. For several machines any scheduler that transfers a file and calls a function is sufficient;
this example uses Dask. Without an argument the script starts two workers on this machine; `--scheduler ADDRESS` uses an existing scheduler.
Each task simulates a gearmotor that lifts a load for five minutes, at one supply voltage and one load torque.
"""

import argparse
import json
from functools import lru_cache
from itertools import product
from pathlib import Path

from clients.paths import archive
from dask.distributed import Client, LocalCluster, get_worker

MODEL = "BrushedGearmotor"
VOLTAGES, LOADS = (9.0, 12.0, 15.0), (0.1, 0.2, 0.3, 0.4)  # V, N.m
SECONDS, STEP = 300.0, 0.5


@lru_cache(maxsize=1)
def unpacked(path: str):
    """The archive, unpacked once in each worker's process."""
    from clients.fmu import Archive

    return Archive(path)


def lift(path: str, voltage: float, load: float) -> dict:
    """Speed and winding temperature after five minutes."""
    with unpacked(path).instance() as motor:
        motor.initialise({"duty": 1.0, "supply_voltage": voltage, "load_torque": load})
        for _ in range(round(SECONDS / STEP)):
            motor.step(STEP)
        speed, winding, taken, given = motor.get("shaft_speed", "winding_temperature", "energy_supply", "energy_shaft")
    return {
        "supply_voltage_V": voltage,
        "load_torque_Nm": load,
        "shaft_speed_rad_per_s": speed,
        "winding_temperature_degC": winding - 273.15,
        "efficiency_percent": 100.0 * given / taken,
    }


def on_worker(name: str, voltage: float, load: float) -> tuple[dict, str]:
    """A task on a worker, with the FMU file that was transferred to it; also returns the address of the worker."""
    worker = get_worker()
    return lift(str(Path(worker.local_directory) / name), voltage, load), worker.address


def sweep(client: Client) -> tuple[list[dict], int]:
    """All points in order, and the number of workers that computed them."""
    path = archive(MODEL, 3)
    client.upload_file(str(path), load=False)
    jobs = [client.submit(on_worker, path.name, *point, pure=False) for point in product(VOLTAGES, LOADS)]
    rows, workers = zip(*client.gather(jobs))
    return list(rows), len(set(workers))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scheduler", help="address of a scheduler; default: two workers on this machine")
    scheduler = parser.parse_args().scheduler
    if scheduler:
        with Client(scheduler) as client:
            points, workers = sweep(client)
    else:
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            client.wait_for_workers(2)
            points, workers = sweep(client)
    print(json.dumps({"workers": workers, "points": points}, indent=2))
