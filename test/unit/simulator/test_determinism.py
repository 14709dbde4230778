"""The same seed and the same bytes at the same simulated times give the same answers.

This holds in every process and on every computer, and does not depend on how time is split.
"""

import os
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "bench"))

import determinism as bench

MINUTES = 2.0
EXPECTED = "64a40b7065ff1e4e6b0c8df24c7e3e48aa86f30cf1497cf12e228b98f2cc49eb"
"""The hash of all bytes of these minutes.

If you change on purpose what a robot does or sends, put the new hash here: ``python3 bench/determinism.py --minutes 2``
prints it.
"""


def test_four_robots_send_the_same_bytes_in_every_process_and_however_time_is_split():
    script, minutes = bench.__file__, str(MINUTES)
    other = subprocess.run(
        [sys.executable, script, "--minutes", minutes, "--split", "3"],
        stdout=subprocess.PIPE, check=True, env=dict(os.environ, PYTHONHASHSEED="4242"))
    digest, contacts = bench.everything_sent(MINUTES)
    assert other.stdout.decode().split()[0] == digest
    assert digest == EXPECTED       # as on every other computer
    assert min(contacts) > 0        # or it would not show much


def test_another_seed_sends_other_bytes():
    assert bench.everything_sent(0.1)[0] != bench.everything_sent(0.1, seed=5)[0]
