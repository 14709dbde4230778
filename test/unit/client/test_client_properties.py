"""What holds for a session with any user and any bytes from the line. hypothesis searches for counterexamples."""

import math

from hypothesis import example, given, settings
from hypothesis import strategies as some

from pioneer_control import p2os
from pioneer_control.client.odometry import Odometry
from pioneer_control.client.line import LONGEST_QUEUE
from pioneer_control.errors import LinkLostError, PioneerError

from fake_robot import STEP, Bench, config, sip

TIMEOUT = 0.6
REACTION = 0.1
RATES = some.one_of(some.floats(-2, 2), some.sampled_from([0.0, math.nan, math.inf, -1e300, 1e-9]))
FRAMES = some.one_of(
    some.builds(p2os.encode_frame, some.integers(0, 255), some.binary(max_size=60)),
    some.builds(lambda **fields: p2os.encode_packet(sip(**fields)),
                x_counts=some.integers(0, 32767), y_counts=some.integers(0, 32767),
                heading_units=some.integers(0, 4095), left_velocity_units=some.integers(-500, 500),
                flags=some.integers(0, 0xFFFF).map(p2os.Flags)),
    some.builds(lambda **fields: p2os.encode_packet(config(**fields)), watchdog_ms=some.integers(0, 3000),
                translation_velocity_max_mm_s=some.integers(0, 2000)),
)
ACTIONS = some.one_of(
    some.tuples(some.just("bytes"), some.one_of(some.binary(max_size=60), FRAMES)),
    some.tuples(some.just("time"), some.sampled_from([0.005, 0.1, 0.35, 0.7, 2.1])),
    some.tuples(some.just("hold-up"), some.sampled_from([0.3, 1.0, 5.0])),
    some.tuples(some.just("velocity"), some.tuples(RATES, RATES)),
    some.tuples(some.just("stop"), some.none()),
    some.tuples(some.just("motors"), some.booleans()),
    some.tuples(some.just("command"),
                some.sampled_from([p2os.encode_command("SONAR", 1), p2os.encode_command("TTY2", b"x" * 100)])),
    some.tuples(some.just("deaf"), some.booleans()),
    some.tuples(some.just("mute"), some.booleans()),
    some.tuples(some.just("STOP button"), some.booleans()),
    some.tuples(some.sampled_from(["close", "fail"]), some.none()),
)


class Watched:
    """A bench whose user follows a script. It notes what the user asked for, and when."""

    def __init__(self, rates):
        self.bench = Bench(rates=rates, command_timeout=TIMEOUT)
        self.commanded_at = -math.inf
        self.motors = []            # requests
        self.checked = 0

    def do(self, action, value):
        """Do one action. It may only raise a PioneerError."""
        bench, session = self.bench, self.bench.session
        if action == "time":
            end = bench.now + value
            while bench.now < end - STEP / 2:
                bench.step()
                self.check()
        elif action == "hold-up":
            bench.now += value
        elif action == "bytes":
            session.receive(value, bench.now)
        elif action == "deaf":
            bench.robot.deaf = lambda heard: value
        elif action == "mute":
            bench.robot.mute = lambda packet: value
        elif action == "STOP button":
            bench.robot.press_stop_button(value)
        elif action == "close":
            session.close(bench.now)
        elif action == "fail":
            session.fail(LinkLostError("pulled"))
        elif session.connected:
            self.command(action, value)
        bench.act()
        self.check()

    def command(self, action, value):
        bench, session = self.bench, self.bench.session
        try:
            if action == "velocity":
                session.connected.drive.set_velocity(*value, bench.now)
                self.commanded_at = bench.now
            elif action == "stop":
                session.connected.drive.stop(bench.now)
            elif action == "motors":
                self.motors.append(session.connected.drive.request_motors(value, bench.now, 2.0))
            else:
                session.connected.command(bench.now, value)
        except PioneerError:
            pass

    def check(self):
        """Check what was written since the last call."""
        bench = self.bench
        for heard in bench.robot.heard[self.checked:]:
            if heard.name in ("VEL", "RVEL") and heard.value:
                assert heard.time <= self.commanded_at + TIMEOUT + REACTION, "older than its time-out: %s" % (heard,)
            if heard.name == "ENABLE" and heard.value:
                assert any(request.on for request in self.motors), "nobody asked for motors"
        self.checked = len(bench.robot.heard)
        assert bench.session.line.waiting <= LONGEST_QUEUE
        assert len(bench.session._link.decoder._held) <= 258
        if bench.finished:
            assert bench.session.wake_at == math.inf
            assert all(request.done for request in self.motors)


@given(some.lists(ACTIONS, max_size=40), some.booleans(), some.sampled_from([(), (9600, 38400)]))
@settings(max_examples=150)
@example([("time", 0.7), ("motors", True), ("hold-up", 5.0)], False, ())
@example(
    [("motors", True), ("time", 0.35), ("velocity", (0.3, 0.5)), ("deaf", True), ("time", 2.1), ("deaf", False),
     ("time", 2.1)],
    True, ())
def test_no_script_makes_it_raise_or_move_by_itself(script, ready, rates):
    watched = Watched(rates)
    if ready:
        watched.bench.until_ready()
    for action, value in script:
        watched.do(action, value)
    watched.bench.robot.deaf = watched.bench.robot.mute = lambda packet: False
    watched.do("time", 1.5)
    if watched.bench.session.connected:
        assert not watched.bench.robot.moving, "nobody has commanded it for longer than its time-out"
        confirmed = any(request.on and request.done and request.error is None for request in watched.motors)
        assert confirmed or not watched.bench.robot.motors, "whoever asked for motors was told that they are off"
    watched.do("close", None)
    watched.do("time", 1.0)
    assert watched.bench.finished and isinstance(watched.bench.session.error, (PioneerError, type(None)))
    said = len(watched.bench.robot.heard)
    watched.do("bytes", p2os.encode_packet(sip()))
    watched.do("time", 2.1)
    assert len(watched.bench.robot.heard) == said, "nothing is said after the end"


@given(
    some.lists(
        some.tuples(some.integers(-16000, 16000), some.integers(-16000, 16000), some.integers(-2000, 2000)),
        max_size=30),
    some.tuples(some.integers(0, 32767), some.integers(0, 32767), some.integers(0, 4095)))
def test_odometry_is_the_sum_of_its_steps(steps, start):
    odometry = Odometry(0.485, 4096)
    x, y, heading = start
    odometry.update(x, y, heading)
    for forward, left, turn in steps:
        x, y, heading = x + forward, y + left, heading + turn
        odometry.update(x & 0x7FFF, y & 0x7FFF, heading % 4096)
    ahead, left, turned = x - start[0], y - start[1], heading - start[2]
    assert (odometry.x_counts, odometry.y_counts, odometry.heading_units) == (ahead, left, turned)
    assert math.isclose(math.hypot(*odometry.pose[:2]), math.hypot(ahead, left) * 0.485 / 1000, abs_tol=1e-6)


@given(some.integers(), some.integers(1, 1 << 20).map(lambda half: 2 * half))
def test_a_wrapped_step_is_the_shortest_and_the_same_on_the_circle(difference, full):
    step = p2os.wrapped(difference, full)
    assert -full // 2 <= step < full // 2 and (step - difference) % full == 0
