"""What backends tell again: a status when it is time to, a text of the world when it has changed."""

import types

from pioneer_control.web.backend import COUNTS_EVERY, STATUS_EVERY, StatusPace
from pioneer_control.web.from_messages import WorldPicture, diagnosed

GRID = types.SimpleNamespace(data=[0], info=types.SimpleNamespace(
    width=1, height=1, resolution=1.0, origin=types.SimpleNamespace(
        position=types.SimpleNamespace(x=0.0, y=0.0), orientation=types.SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0))))


def test_a_status_is_told_when_it_has_changed_and_its_counts_seldom():
    pace = StatusPace()
    assert pace.is_due(10.0)
    assert pace.take({"link": "ok", "counts": 1}, 10.0, "counts")
    assert not pace.is_due(10.0 + STATUS_EVERY - 0.01) and pace.is_due(10.0 + STATUS_EVERY)
    assert pace.take({"link": "ok", "counts": 2}, 11.0, "counts") is None
    assert pace.take({"link": "ok", "counts": 2}, 10.0 + COUNTS_EVERY, "counts") == {"link": "ok", "counts": 2}
    assert pace.take({"link": "lost", "counts": 2}, 15.5, "counts") == {"link": "lost", "counts": 2}


def test_a_name_that_comes_after_its_map_is_told():
    world = WorldPicture()
    assert world.changes([]) == []
    world.take("map", GRID, 0.0)
    (kind, told), = world.changes([])
    assert (kind, told["name"]) == ("world", "")
    assert world.changes([]) == []
    world.take("world", types.SimpleNamespace(data="office"), 0.0)
    assert [value["name"] for _, value in world.changes([])] == ["office"]


def test_cans_that_are_gone_are_told():
    world = WorldPicture()
    can = types.SimpleNamespace(position=types.SimpleNamespace(x=1.0, y=2.0, z=0.0))
    for poses, told in (([can], [[1.0, 2.0, 0.0]]), ([], [])):
        world.take("cans", types.SimpleNamespace(poses=poses), 0.0)
        assert world.changes([]) == [("cans", told)]


def test_diagnostics_are_those_of_a_node_in_its_namespace():
    found = diagnosed(types.SimpleNamespace(status=[
        types.SimpleNamespace(name="/lab/pioneer/p2os_driver: Battery", level=1, message="low"),
        types.SimpleNamespace(name="computer", level=b"\x02", message="hot")]))
    assert list(found) == [("lab/pioneer", "Battery", 1, "low"), ("", "computer", 2, "hot")]
