"""Pushed cans, as the simulator's node reports them."""

from robot_on_bench import Bench

from pioneer_control.p2os import GripperCommand
from pioneer_control.simulator.shoves import ShoveWatch
from pioneer_control.simulator.world import Can, World


class Watched:
    """A robot whose pushes are watched ten times a second."""

    def __init__(self, *cans, **options):
        self.bench = Bench(world=World("cans", cans=[Can(x, y) for x, y in cans]), **options).open()
        self.watch = ShoveWatch(self.bench.robot.world.cans)
        self.told = []

    def wait(self, seconds):
        for _ in range(round(seconds * 10)):
            self.bench.send("PULSE").wait(0.1)
            robot = self.bench.robot
            self.told += self.watch.look(robot.time, [("far", (9.0, 9.0)), ("the robot", robot.true_pose[:2])])
        return self

    def tell(self, name, *values):
        self.bench.send(name, *values)
        return self


def test_a_shove_is_told_once_when_the_can_stands_again():
    watched = Watched((0.5, 0.0), (0.5, 2.0), gripper=False).tell("MOVE", 500).wait(2.0)
    assert watched.told == []
    watched.wait(4.0)
    assert watched.told == ["the robot pushed can 1 by 0.24 m, from x 0.50, y 0.00 to x 0.74, y 0.00"]
    watched.tell("MOVE", -300).wait(4.0).tell("MOVE", 400).wait(6.0)
    assert len(watched.told) == 2 and watched.told[1].startswith("the robot pushed can 1 by 0.1")


def test_what_is_picked_and_carried_is_no_shove():
    watched = Watched((0.31, 0.03)).tell("GRIPPER", int(GripperCommand.LIFT_DOWN)).wait(4.5)
    watched.tell("GRIPPER", int(GripperCommand.CLOSE)).wait(3.5).tell("MOVE", 500).wait(4.0)
    assert watched.bench.robot.gripper.held_can is not None and watched.bench.robot.world.cans[0].x > 0.6
    watched.tell("GRIPPER", int(GripperCommand.OPEN)).wait(5.0)
    assert watched.told == [] and watched.watch.finish() == []


def test_a_shove_that_goes_on_is_told_at_the_end():
    watched = Watched((0.5, 0.0), gripper=False).tell("VEL", 200).wait(4.0)
    assert watched.told == []
    sentence, = watched.watch.finish()
    assert sentence.startswith("the robot pushed can 1 by 0.") and watched.watch.finish() == []


def test_a_touch_is_not_told():
    watched = Watched((0.24 + 0.033, 0.0), gripper=False).tell("MOVE", 35).wait(4.0)
    assert 0.0 < watched.bench.robot.world.cans[0].x - 0.273 < 0.01 and watched.told == []
