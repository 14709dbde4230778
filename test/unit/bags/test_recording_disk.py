"""The messages about the free space on a disk."""

import pytest

from pioneer_control.bags.recording.plan import GB, KB, MB, in_words, room

KEEP = 256 * MB


@pytest.mark.parametrize("free, rate, words", [
    (KEEP + 300 * MB, 30 * MB, "room for about 10 hours at the usual 30 MB an hour"),
    (KEEP + 100 * GB, 60 * MB, "room for about 71 days at the usual 60 MB an hour"),
    (KEEP + 30 * MB, 60 * MB, "room for about 30 minutes at the usual 60 MB an hour"),
    (KEEP, 25 * MB, "room for about 0 s at the usual 25 MB an hour"),
    (KEEP - MB, 25 * MB, "room for about 0 s at the usual 25 MB an hour"),
    (KEEP + 10 ** 4 * GB, 60 * MB, "room for more than a year at the usual 60 MB an hour")])
def test_how_long_there_is_room(free, rate, words):
    assert room(free, KEEP, rate) == words


@pytest.mark.parametrize("size, words", [
    (0, "0 bytes"),
    (2 * KB, "2 kB"),
    (1.5 * MB, "1.5 MB"),
    (999 * MB, "999 MB"),
    (65.2 * GB, "65.2 GB"),
])
def test_sizes_for_people(size, words):
    assert in_words(size) == words
