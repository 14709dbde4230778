"""The session with a laser: it is found, configured, heard, lost and told to stop. A scripted laser answers."""

import math

import pytest

from pioneer_control import lms2xx
from pioneer_control.errors import ParameterError
from pioneer_control.laser.conversation import SetLineSpeed
from pioneer_control.laser.session import LaserLost, Measuring, ScanHeard, LaserSession
from pioneer_control.laser.settings import LaserSettings

SCAN = lms2xx.RawScan((1000,) * 361)


class ScriptedLaser:
    """A laser that answers at once, at one speed; each of its ways to misbehave is an attribute."""

    def __init__(self, baud=9600):
        self.baud, self.next_baud, self.power = baud, baud, True
        self.variant, self.configuration = (180, 50), lms2xx.FACTORY
        self.streams = self.installation = False
        self.password, self.deaf, self.naks, self.carries = b"SICK_LMS", 0, 0, True
        self.refuses, self.silent_on, self.forgets, self.writes = (), (), False, 0
        self.hears_every_speed, self.speed_word = False, None
        self.heard, self.errors = [], b""
        self._decoder = lms2xx.TelegramDecoder(from_laser=False)

    def hear(self, data, baud):
        """Return what it answers to bytes at some speed."""
        if self.hears_every_speed:
            baud = None
        if not self.power or baud not in (None, self.baud) or not self.carries and self.baud == 500000:
            return b""
        answer = b""
        for telegram in self._decoder.feed(data):
            request = lms2xx.decode(telegram)
            self.heard.append(request)
            if self.deaf:
                self.deaf -= 1
            elif type(request).__name__ in self.silent_on:
                answer += b"\x06"
            elif self.naks:
                self.naks -= 1
                answer += b"\x15"
            elif type(request).__name__ in self.refuses:
                answer += b"\x06" + lms2xx.encode(lms2xx.NotPossible())
            else:
                answer += b"\x06" + lms2xx.encode(self.reply_to(request))
        return answer

    def reply_to(self, request):
        if isinstance(request, lms2xx.SetMode):
            return self.set_mode(request)
        if isinstance(request, lms2xx.AskType):
            return lms2xx.TypeReply(b"LMS200;301063;V02.10 ")
        if isinstance(request, lms2xx.AskErrors):
            return lms2xx.ErrorsReply(self.errors)
        if isinstance(request, lms2xx.AskStatus):
            word = self.speed_word or lms2xx.SPEEDS[self.baud].word
            return lms2xx.StatusReply("V02.10 ", 0x25, 0, (0,) * 8, 0, (0,) * 48, 148, (0,) * 33, 0, (0,) * 4,
                                      *self.variant, 2, (0,) * 4, word, 2, 0, 0, 0, 1, 1, "V02.10 ", (0,) * 22)
        if isinstance(request, lms2xx.SetVariant):
            accepted = tuple(vars(request).values()) in lms2xx.VARIANTS
            if accepted:
                self.variant = request.angle_deg, request.step_hundredths
            return lms2xx.VariantSet(int(accepted), *self.variant)
        if isinstance(request, lms2xx.WriteConfiguration):
            assert self.installation
            self.writes += 1
            if not self.forgets:
                self.configuration = request.configuration.over(self.configuration)
            return lms2xx.ConfigurationWritten(1, self.configuration)
        return lms2xx.ConfigurationReply(self.configuration)

    def set_mode(self, request):
        if request.mode == lms2xx.Mode.INSTALLATION and request.parameters != self.password:
            return lms2xx.ModeSet(1)
        self.installation = request.mode == lms2xx.Mode.INSTALLATION
        self.streams = request.mode == lms2xx.Mode.STREAM
        self.next_baud = next((baud for baud, speed in lms2xx.SPEEDS.items() if speed.mode == request.mode), self.baud)
        return lms2xx.ModeSet(0)


class Bench:
    """A session and a laser, on a line with a clock."""

    def __init__(self, laser=None, has_speed=True, **settings):
        self.laser = laser or ScriptedLaser()
        self.now, self.port_baud = 100.0, None
        self.speeds = []
        self.session = LaserSession(LaserSettings(**settings), has_speed, self.now)
        self.events = []

    def step(self):
        """Let the next thing happen that is due."""
        self.now = max(self.now, min(self.session.due, self.now + 60.0))
        self.events += self.session.tick(self.now)
        self.carry()

    def carry(self):
        for output in self.session.take_output():
            if isinstance(output, SetLineSpeed):
                self.port_baud = output.baud
                self.speeds.append(output.baud)
                continue
            answer = self.laser.hear(output, self.port_baud)
            if answer:
                self.events += self.session.receive(answer, self.now)
                self.laser.baud = self.laser.next_baud
                self.carry()

    def until(self, kind, most=400):
        for _ in range(most):
            found = [event for event in self.events if isinstance(event, kind)]
            if found:
                self.events.remove(found[0])
                return found[0]
            self.step()
        raise AssertionError("no %s; %s" % (kind.__name__, self.events))

    def scans(self, count=1, values=SCAN, status=lms2xx.WELL):
        for _ in range(count):
            self.now += 0.2
            self.events += self.session.receive(lms2xx.encode(lms2xx.ScanReply(values), status), self.now)


def test_a_laser_is_found_taken_to_the_wanted_speed_and_measures():
    bench = Bench()
    info = bench.until(Measuring).info
    assert info.type == "LMS200;301063;V02.10" and info.variant == (180, 50) and info.remarks == ()
    assert (info.found_baud, info.baud) == (9600, 38400) == (bench.speeds[1], bench.laser.baud)
    assert bench.laser.streams and bench.laser.writes == 0
    assert bench.session.info is info


@pytest.mark.parametrize("baud", [9600, 19200, 38400, 500000])
def test_it_is_found_at_every_speed(baud):
    bench = Bench(ScriptedLaser(baud), baud=38400)
    info = bench.until(Measuring).info
    assert info.found_baud == baud and bench.laser.baud == 38400
    assert bench.now - 100.0 < 10.0


def test_on_a_socket_there_is_no_speed_to_set():
    bench = Bench(ScriptedLaser(19200), has_speed=False, baud=38400)
    info = bench.until(Measuring).info
    assert (info.baud, info.found_baud, bench.speeds) == (19200, 19200, [])
    assert not any(isinstance(heard, lms2xx.SetMode) and heard.mode == 0x40 for heard in bench.laser.heard)


def test_on_a_line_that_takes_every_speed_the_laser_says_its_own():
    """A pseudo-terminal is such a line. The laser is found with the first speed, but sends at another one."""
    bench = Bench(ScriptedLaser(19200), baud=500000)
    bench.laser.hears_every_speed = True
    info = bench.until(Measuring).info
    assert (info.found_baud, info.baud, bench.laser.baud) == (19200, 500000, 500000)


@pytest.mark.parametrize("has_speed", [True, False])
def test_a_speed_that_nobody_knows_counts_less_than_that_of_the_port(has_speed):
    bench = Bench(has_speed=has_speed)
    bench.laser.speed_word = 0x8123
    if has_speed:
        assert bench.until(Measuring).info.found_baud == 9600
    else:
        assert "the speed 8123, which none has" in bench.until(LaserLost).reason


@pytest.mark.parametrize("scan", [
    lms2xx.RawScan((1000,) * 181), SCAN._replace(partial=True), SCAN._replace(unit=3)])
def test_a_scan_that_it_was_not_told_to_send_is_none(scan):
    bench = Bench()
    bench.until(Measuring)
    bench.scans(values=scan)
    assert bench.events == [] and bench.session.counts.malformed == 1 and bench.session.counts.scans == 0
    bench.scans()
    assert bench.until(ScanHeard).scan == SCAN


def test_scans_have_the_time_of_their_first_ray():
    bench = Bench()
    info = bench.until(Measuring).info
    bench.scans()
    scan = bench.until(ScanHeard)
    assert scan.scan == SCAN and scan.status == lms2xx.WELL and scan.info is info
    # 732 bytes of 10 bits at 38400 baud, and two turns of the mirror
    assert bench.now - scan.first_ray == pytest.approx(732 * 10 / 38400 + 2 / 75.0)
    assert bench.session.counts.scans == 1


def test_of_two_scans_in_one_read_the_first_is_older():
    bench = Bench()
    bench.until(Measuring)
    data = lms2xx.encode(lms2xx.ScanReply(SCAN))
    first, second = bench.session.receive(data + data + data[:100], 200.0)
    # One begins 8 turns of the mirror after the other, though the line carries it in less.
    assert second.first_ray - first.first_ray == pytest.approx(16 / 75.0)
    assert 200.0 - second.first_ray == pytest.approx(100 * 10 / 38400 + (16 + 2) / 75.0)


def test_a_laser_that_is_ready_is_found_in_a_moment_at_every_speed():
    for baud in lms2xx.SPEEDS:
        bench = Bench(ScriptedLaser(baud), baud=38400)
        bench.until(Measuring)
        assert bench.now - 100.0 < 2.2, baud


def test_a_laser_that_heard_the_request_gets_its_time_to_answer():
    """It may need a second to change its mode."""
    bench = Bench(ScriptedLaser(38400))
    bench.laser.silent_on = ("SetMode",)        # but for ACK
    while not bench.laser.heard:
        bench.step()
    assert bench.session.due == pytest.approx(bench.now + 1.0) and bench.port_baud == 38400
    bench.now += 0.9
    bench.laser.silent_on = ()
    bench.events += bench.session.receive(lms2xx.encode(lms2xx.ModeSet(0)), bench.now)
    assert bench.until(Measuring).info.found_baud == 38400


@pytest.mark.parametrize("baud", sorted(lms2xx.SPEEDS))
def test_a_laser_that_takes_almost_3_s_for_each_change_of_its_mode_is_found(baud):
    """So long it may take. It hears nothing meanwhile, and says at once that it heard the request."""
    bench = Bench(ScriptedLaser(baud), baud=38400)
    hear, late = bench.laser.hear, []

    def hear_slowly(data, baud):
        if late:
            return b""
        answer = hear(data, baud)
        if b"\x02\x80\x03\x00\xa0" in answer:
            late.append((bench.now + 2.9, baud, answer[1:]))
        return answer[:1] if late else answer

    bench.laser.hear = hear_slowly
    while not any(isinstance(event, Measuring) for event in bench.events):
        assert bench.now < 140.0, bench.events
        if late and late[0][0] <= bench.session.due:
            bench.now, sent_at, answer = late.pop()
            if bench.port_baud == sent_at:
                bench.events += bench.session.receive(answer, bench.now)
                bench.carry()
        else:
            bench.step()
    assert bench.until(Measuring).info.found_baud == baud


@pytest.mark.parametrize("message", [
    lms2xx.PowerOn(b"LMS200;301063;V02.10 "), lms2xx.Resetting(), lms2xx.VariantSet(1, 100, 100),
    lms2xx.ConfigurationWritten(1, lms2xx.FACTORY.changed(measuring_mode=5))])
def test_who_changes_the_laser_meanwhile_ends_what_is_known_of_it(message):
    """The measuring mode is in no scan: with another one the distances would be wrong."""
    bench = Bench()
    bench.until(Measuring)
    bench.scans()
    bench.events += bench.session.receive(lms2xx.encode(message), bench.now)
    assert "another program has changed it" in bench.until(LaserLost).reason
    seen = len(bench.events)
    bench.scans()
    assert len(bench.events) == seen, "no scan is believed until it was asked anew"
    bench.until(Measuring)


def test_what_it_missed_is_said_again():
    bench = Bench()
    bench.laser.deaf = 1
    bench.until(Measuring)
    assert bench.session.counts.repeated >= 1


def test_after_a_nak_it_waits_30_ms_and_says_it_again():
    bench = Bench(ScriptedLaser(38400))
    bench.laser.naks = 1
    while not bench.laser.heard:
        bench.step()
    begun = bench.now
    while len(bench.laser.heard) == 1:
        bench.step()
    assert bench.now - begun == pytest.approx(0.03) and bench.laser.heard[0] == bench.laser.heard[1]
    bench.until(Measuring)


def test_a_laser_that_streams_is_found_by_its_scans():
    bench = Bench(ScriptedLaser(38400))
    bench.laser.deaf = 1
    bench.step()
    bench.scans()
    assert bench.until(Measuring).info.found_baud == 38400


def test_a_laser_that_has_just_got_power_is_waited_for():
    bench = Bench(power_on=65.0)
    bench.laser.power = False
    while bench.now < 130.0:
        bench.step()
    assert bench.events == []
    bench.laser.power = True
    assert bench.until(Measuring).info.found_baud == 9600


def test_without_a_laser_it_says_so_and_goes_on_to_look():
    bench = Bench(power_on=0.0)
    bench.laser.power = False
    lost = bench.until(LaserLost)
    assert "no laser answers at 38400, 9600, 19200, 500000 baud" in lost.reason
    bench.laser.power = True
    bench.until(Measuring)


def test_a_stream_that_falls_silent_is_lost_and_found_again():
    bench = Bench()
    bench.until(Measuring)
    bench.scans(3)
    bench.laser.power = False
    lost = bench.until(LaserLost)
    assert "silent for" in lost.reason and bench.session.info is None and bench.session.counts.lost == 1
    bench.laser.power, bench.laser.baud = True, 9600
    bench.until(Measuring)


def test_a_broken_line_begins_anew():
    bench = Bench()
    bench.until(Measuring)
    assert bench.session.line_broke("the cable", bench.now) == [LaserLost("the cable")]
    assert bench.session.take_output() == []
    bench.until(Measuring)


def test_at_the_end_it_stops_and_gets_its_speed_back():
    bench = Bench()
    bench.until(Measuring)
    before = bench.now
    bench.session.close(bench.now)
    bench.carry()
    bench.step()
    assert bench.session.closed and not bench.laser.streams and bench.laser.baud == 9600
    assert bench.now == before and bench.speeds[-1] == 38400, "it is told so at its own speed"


def test_a_laser_that_is_gone_does_not_keep_it_at_the_end():
    bench = Bench()
    bench.until(Measuring)
    bench.laser.power = False
    bench.session.close(bench.now)
    for _ in range(20):
        bench.step()
    assert bench.session.closed and bench.session.due == math.inf
    assert bench.session.tick(bench.now + 100.0) == []


def test_closed_before_a_laser_is_found():
    bench = Bench()
    bench.session.close(bench.now)
    assert bench.session.closed


@pytest.mark.parametrize("steps", range(9))
def test_closed_at_any_moment_it_leaves_the_laser_as_it_was(steps):
    """Between the answer to a new speed and the first request at that speed, too."""
    bench = Bench(writes=True, unit=0, angle_deg=100)
    for _ in range(steps):
        bench.step()
    bench.session.close(bench.now)
    for _ in range(20):
        bench.carry()
        if not bench.session.closed:
            bench.step()
    assert bench.session.closed and not bench.laser.streams and bench.laser.baud == 9600


def test_closed_while_it_is_told_another_speed_it_gets_its_own_back():
    """The answer comes at the old speed: it was taken for that to the stop, and the laser stayed at the new one."""
    bench, late = Bench(), []
    receive = bench.session.receive

    def hold_back(data, now):
        if bench.laser.next_baud == bench.laser.baud or late:
            return receive(data, now)
        late.append(data)
        return []

    bench.session.receive = hold_back
    while not late:
        bench.step()
    bench.session.close(bench.now)
    bench.carry()
    bench.events += receive(late[0], bench.now)
    for _ in range(20):
        bench.carry()
        if not bench.session.closed:
            bench.step()
    assert bench.session.closed and not bench.laser.streams and bench.laser.baud == 9600


def test_the_variant_is_set_without_a_write():
    bench = Bench(angle_deg=100, step_hundredths=25)
    assert bench.until(Measuring).info.variant == (100, 25)
    assert bench.laser.writes == 0


def test_a_step_that_does_not_go_with_the_angle_of_the_laser_is_told():
    info = Bench(step_hundredths=25).until(Measuring).info
    assert info.variant == (180, 50)
    assert info.remarks == ("it looks 180 degrees wide in steps of 0.50: it refuses 180 and 0.25",)


def test_a_laser_that_answers_92_to_another_angle_measures_as_it_does():
    bench = Bench(angle_deg=100)
    bench.laser.refuses = ("SetVariant",)
    info = bench.until(Measuring).info
    assert info.variant == (180, 50)
    assert info.remarks == ("it looks 180 degrees wide in steps of 0.50: it refuses 100 and 0.50",)


def test_a_laser_that_does_not_answer_when_it_is_told_another_angle():
    bench = Bench(angle_deg=100)
    bench.laser.silent_on = ("SetVariant",)
    assert bench.until(LaserLost).reason == "the laser does not answer SetVariant"


@pytest.mark.parametrize("variant", [(180, 0), (180, 33), (0, 50), (180, 25), (65535, 65535)])
def test_a_variant_in_which_no_laser_looks_is_told_until_another_one_is_given(variant):
    bench = Bench()
    bench.laser.variant = variant
    assert "degrees wide in steps of %.2f, which none can" % (variant[1] / 100.0) in bench.until(LaserLost).reason
    bench = Bench(angle_deg=180, step_hundredths=100)
    bench.laser.variant = variant
    assert bench.until(Measuring).info.variant == (180, 100)


def test_a_type_that_looks_90_degrees_wide_is_as_good_as_any():
    bench = Bench()
    bench.laser.variant = 90, 50
    assert bench.until(Measuring).info.variant == (90, 50)


def test_nothing_is_written_unasked():
    bench = Bench(unit=0, measuring_mode=1)
    info = bench.until(Measuring).info
    assert bench.laser.writes == 0 and info.configuration == lms2xx.FACTORY
    assert len(info.remarks) == 2 and "its unit is 1, not 0" in info.remarks[0]


def test_nothing_is_written_that_is_there_already():
    bench = Bench(unit=1, measuring_mode=0, writes=True)
    assert bench.until(Measuring).info.remarks == () and bench.laser.writes == 0


def test_what_differs_is_written_once_when_it_may_be():
    bench = Bench(unit=0, measuring_mode=1, writes=True)
    info = bench.until(Measuring).info
    assert bench.laser.writes == 1 and info.remarks == ()
    assert (info.configuration.unit, info.configuration.measuring_mode) == (0, 1)
    assert info.configuration.stop_threshold_mv == 70, "the rest stays"
    assert not bench.laser.installation


@pytest.mark.parametrize("trouble, said", [
    (dict(password=b"SECRET__"), "does not take the password 'SICK_LMS'"),
    (dict(forgets=True), "keeps 1 and 0"),
    (dict(refuses=("WriteConfiguration",)), "refuses WriteConfiguration"),
    (dict(refuses=("AskStatus",)), "refuses AskStatus"),
])
def test_what_goes_wrong_is_told(trouble, said):
    bench = Bench(unit=0, writes=True)
    vars(bench.laser).update(trouble)
    assert said in bench.until(LaserLost).reason and not bench.laser.streams


def test_a_line_that_does_not_carry_the_speed():
    bench = Bench(baud=500000)
    bench.laser.carries = False
    assert "500000 baud, but does not answer there" in bench.until(LaserLost).reason


def test_a_measuring_mode_that_nobody_has_explained():
    bench = Bench()
    bench.laser.configuration = lms2xx.FACTORY.changed(measuring_mode=13)
    assert "mode 0D" in bench.until(LaserLost).reason


def test_a_measuring_mode_that_is_no_distance():
    bench = Bench()
    bench.laser.configuration = lms2xx.FACTORY.changed(measuring_mode=0x3F)
    assert "mode 3F, the strength of echoes: give another measuring_mode" in bench.until(LaserLost).reason


WARNING, DONE = lms2xx.DeviceError(2, 18, False), lms2xx.DeviceError(2, 18, True)


def test_a_laser_is_asked_for_its_errors_before_it_streams():
    bench = Bench()
    bench.laser.errors = bytes((2, 18, 0x82, 18))
    assert bench.until(Measuring).info.errors == (WARNING, DONE)


@pytest.mark.parametrize("trouble", [dict(refuses=("AskErrors",)), dict(silent_on=("AskErrors",))])
def test_a_laser_that_does_not_tell_its_errors_measures_all_the_same(trouble):
    bench = Bench()
    vars(bench.laser).update(trouble)
    assert bench.until(Measuring).info.errors == ()


def test_errors_that_come_while_it_streams_are_asked_for_once():
    bench = Bench()
    bench.until(Measuring)
    bench.scans(3)
    asked = bench.laser.heard.count(lms2xx.AskErrors())
    bench.laser.errors = bytes((2, 18))
    for _ in range(40):     # 8 s
        bench.scans(status=0x12)
        bench.carry()
    assert bench.laser.heard.count(lms2xx.AskErrors()) == asked + 1
    assert bench.events[-1].info.errors == (WARNING,) and bench.events[-1].status == 0x12
    assert all(isinstance(event, ScanHeard) for event in bench.events), "no scan is lost for it, nor the laser"
    assert len(bench.events) == 43
    bench.laser.errors = bytes((0x82, 18))
    bench.scans()
    bench.carry()
    assert bench.laser.heard.count(lms2xx.AskErrors()) == asked + 1, "not so soon again"
    for _ in range(20):
        bench.scans()
        bench.carry()
    assert bench.laser.heard.count(lms2xx.AskErrors()) == asked + 2
    assert bench.events[-1].info.errors == (DONE,)


def test_a_stream_that_ends_when_the_laser_is_asked_for_errors_is_begun_anew():
    bench = Bench()
    bench.until(Measuring)
    bench.scans(2)
    bench.scans(status=0x13)
    bench.carry()
    assert "silent for" in bench.until(LaserLost).reason
    bench.until(Measuring)


def test_noise_instead_of_scans_is_no_silence():
    bench = Bench()
    bench.until(Measuring)
    for _ in range(30):
        bench.now += 0.1
        bench.events += bench.session.receive(b"\xFF" * 40, bench.now)
        bench.events += bench.session.tick(bench.now)
    assert "what comes is no scan" in bench.until(LaserLost).reason


def test_a_laser_that_falls_silent_when_it_is_asked_for_errors_is_lost():
    bench = Bench()
    bench.until(Measuring)
    bench.scans(2)
    bench.laser.power = False
    bench.scans(status=0x14)
    assert "silent for" in bench.until(LaserLost).reason and bench.now < 120.0


def test_a_status_byte_of_0_is_no_good_one():
    bench = Bench()
    bench.until(Measuring)
    bench.scans(status=0)
    assert bench.until(ScanHeard).status == 0


def test_noise_and_malformed_telegrams_are_counted():
    bench = Bench()
    bench.until(Measuring)
    wrong = bytearray(lms2xx.encode(lms2xx.ScanReply(SCAN)))
    wrong[20] ^= 1
    short = lms2xx.encode_telegram(lms2xx.Telegram(0xB0, b"\x05\x40", 0x10))
    bench.events += bench.session.receive(b"\xFF\x00" + bytes(wrong) + short, bench.now)
    assert bench.events == []
    counts = bench.session.counts
    assert counts.line.wrong_crcs >= 1 and counts.line.discarded_bytes > 700 and counts.malformed == 1


def test_half_a_telegram_is_given_up_after_a_pause():
    bench = Bench()
    bench.until(Measuring)
    data = lms2xx.encode(lms2xx.ScanReply(SCAN))
    assert bench.session.receive(data[:300], bench.now) == []
    assert bench.session.tick(bench.now + 0.05) == []
    bench.session.tick(bench.now + 0.11)
    [scan] = bench.session.receive(data, bench.now + 0.3)
    assert scan.scan == SCAN


@pytest.mark.parametrize("wrong, named", [
    (dict(baud=57600), "baud 57600: legal is one of 9600, 19200, 38400, 500000"),
    (dict(angle_deg=270), "angle_deg 270"),
    (dict(step_hundredths=10), "step_hundredths 10"),
    (dict(unit=2), "unit 2"),
    (dict(measuring_mode=13), "measuring_mode 13"),
    (dict(angle_deg=180, step_hundredths=25), "step of 0.25 degrees"),
    (dict(password=b"short"), "password b'short'"),
    (dict(power_on=-1.0), "power_on -1.0"),
    (dict(power_on=math.nan), "power_on nan"),
])
def test_settings_that_no_laser_has_are_refused(wrong, named):
    with pytest.raises(ParameterError, match=named.replace(".", "[.]")):
        LaserSettings(**wrong)
