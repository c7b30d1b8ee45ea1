"""How long the page of `camgeom serve` waits: every stage of an answer over the loopback, for profiles of every kind.

    python scripts/serve_latency.py [--rounds N] [PROFILE ...]

Each round changes a key, so nothing is remembered. Two numbers a stage, ms since the request, medians of the rounds:
processor time of server and client together, which hangs little on what else the machine does, and wall clock.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from http.client import HTTPConnection
from pathlib import Path
from threading import Thread
from time import perf_counter, process_time

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
SHOWN = ("motion", "figures", "coarse", "checks", "load", "loaded", "bodies", "verdict", "fine")


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Latency of camgeom serve.")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("profiles", nargs="*", type=Path)
    arguments = parser.parse_args()
    paths = arguments.profiles or sorted((ROOT / "profiles").glob("*.toml"))
    print(f"| processor / wall clock, ms | {' | '.join(SHOWN)} |\n|---|{'---|' * len(SHOWN)}")
    for path in paths:
        rounds = [_round(path, n) for n in range(arguments.rounds + 1)][1:]
        told = [[statistics.median(one[name][i] for one in rounds) for i in range(2)] for name in SHOWN]
        print(f"| {path.stem} | {' | '.join(f'{spent:.0f} / {wall:.0f}' for spent, wall in told)} |", flush=True)
    return 0


def _round(path: Path, number: int) -> dict[str, tuple[float, float]]:
    """Processor time and wall clock, ms, from the request to every stage."""
    from camgeom.report.server import HOST, Server

    with Server(path) as server:
        Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        link = HTTPConnection(HOST, server.port, timeout=120)
        body = {"tab": "a", "serial": 1, "text": server.seat.text(), "changes": {"name": f"round {number}"}}
        spent, began = process_time(), perf_counter()
        link.request("POST", f"/{server.token}/answer", json.dumps(body))
        found = {}
        for line in link.getresponse():
            stage = json.loads(line)["stage"]
            found[stage] = 1e3 * (process_time() - spent), 1e3 * (perf_counter() - began)
        link.close()
        server.shutdown()
    return found


if __name__ == "__main__":
    sys.exit(main())
