"""What is said of the room on a disk, and when."""

import pytest

from pioneer_control.bags.recording.disk import GB, MB, DiskWatch, Sample, in_words

KEEP = 256 * MB
RATE = 30 * MB
"""Bytes an hour."""


def look(watch, *samples):
    return [(notice.severity, notice.text) for sample in samples for notice in watch.look(Sample(*sample))]


@pytest.fixture
def watch():
    return DiskWatch("/data", KEEP, RATE)


def test_the_start_says_how_long_there_is_room_at_the_usual_rate(watch):
    severity, text = watch.first(Sample(0.0, KEEP + 300 * MB, 0))
    assert severity == "info" and text == "556 MB free in /data: room for about 10 hours at the usual 30 MB an hour"


def test_after_a_minute_the_measured_rate_counts(watch):
    watch.first(Sample(0.0, 100 * GB, 0))
    assert look(watch, (30.0, 100 * GB, 0), (59.0, 100 * GB - MB, MB)) == []
    (said,) = look(watch, (60.0, 100 * GB - MB, MB))
    assert said == ("info", "60 MB an hour are written: room for about 71 days")
    assert look(watch, (90.0, 100 * GB - 2 * MB, 2 * MB)) == []


def test_others_that_fill_the_disk_count(watch):
    watch.first(Sample(0.0, 100 * GB, 0))
    ((_, text),) = look(watch, (60.0, 99 * GB, MB))
    assert "60 MB an hour are written: room for about 99 minutes (others fill the disk too: 60 GB an hour in all)" == text


def fill(watch, hours, rate=600 * MB, step=10.0):
    """Notices while the disk fills within so many hours and ten minutes beyond: (hours left, severity, text)."""
    size, time = 0.0, 0.0
    free = KEEP + hours * rate
    watch.first(Sample(time, int(free), 0))
    found = []
    while free > KEEP - rate / 6:
        time += step
        size += rate * step / 3600
        free -= rate * step / 3600
        found += [((free - KEEP) / rate, notice.severity, notice.text) for notice in watch.look(Sample(time, int(free), int(size)))]
    return found


def test_it_is_said_well_before_again_before_and_when_it_happens(watch):
    told = [(round(left, 2), severity) for left, severity, _ in fill(watch, 3.0) if severity != "info"]
    assert [severity for _, severity in told] == ["warning", "warning", "error"]
    assert told[0][0] == pytest.approx(1.0, abs=0.01) and told[1][0] == pytest.approx(1 / 6, abs=0.01) and told[2][0] == pytest.approx(0.0, abs=0.01)


def test_a_disk_that_is_nearly_full_at_the_start_is_said_once_at_once(watch):
    watch.first(Sample(0.0, KEEP + MB, 0))
    assert [severity for severity, _ in look(watch, (3.0, KEEP + MB, 0), (6.0, KEEP + MB, 0))] == ["warning"]


def test_what_happens_when_it_is_full_is_said_and_when_there_is_room_again(watch):
    watch.first(Sample(0.0, 10 * GB, 0))
    said = look(watch, (3.0, KEEP - MB, MB), (6.0, KEEP - MB, MB), (9.0, 10 * GB, MB))
    assert [severity for severity, _ in said] == ["error", "warning"]
    assert "rosbag closes the bag, within 20 s, and ends" in said[0][1]
    assert "there is room again" in said[1][1]


def test_room_that_was_made_brings_the_warnings_back(watch):
    first = [severity for _, severity, _ in fill(watch, 1.5)]
    assert first.count("warning") == 2
    assert look(watch, (20000.0, 100 * GB, 10 * GB), (20100.0, 100 * GB, 10 * GB))[0][0] == "warning"      # room again
    said = look(watch, (20200.0, KEEP + 10 * MB, 10 * GB), (20203.0, KEEP + 10 * MB, 10 * GB))
    assert [severity for severity, _ in said] == ["warning"]


def test_a_disk_that_gets_emptier_is_no_rate_below_nothing(watch):
    watch.first(Sample(0.0, 10 * GB, 0))
    assert look(watch, (70.0, 11 * GB, 0)) == [("info", "0 bytes an hour are written: room for more than a year")]


@pytest.mark.parametrize("size, words", [(0, "0 bytes"), (2048, "2 kB"), (1.5 * MB, "1.5 MB"), (999 * MB, "999 MB"), (65.2 * GB, "65.2 GB")])
def test_sizes_for_people(size, words):
    assert in_words(size) == words
