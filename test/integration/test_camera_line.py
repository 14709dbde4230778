"""A camera on a port of its own, in real time: served by the simulator on TCP and on a pseudo-terminal."""

import threading

import pytest

from pioneer_control.errors import ParameterError, PortError, RefusedError
from pioneer_control.ptz import CameraLine, CameraPhase, CameraSession, CameraSettings, session
from pioneer_control.robots import find_model
from pioneer_control.simulator import fault_of, load_world, simulate
from pioneer_control.simulator.line import CameraPorts, Server, camera_ports

LIMIT = 60.0


class Watched:
    """A line to a camera, and the thread that waits for what it tells. ``line`` is the line."""

    def __init__(self, url, **options):
        settings = CameraSettings(power_off_at_end=options.pop("power_off_at_end", False))
        self._news = threading.Condition()
        self.line = CameraLine(url, CameraSession(settings), self._changed, **options)
        self.report = self.line.session.report

    def _changed(self):
        with self._news:
            self.report = self.line.session.report
            self._news.notify_all()

    def until(self, condition):
        with self._news:
            assert self._news.wait_for(lambda: condition(self.report), LIMIT), self.report


def served(robots=1, **ports):
    return Server(simulate(load_world("classroom"), find_model("p3dx-sh"), robots, None, 0), tcp=0, speed=20.0,
                  cameras=CameraPorts("vcc4", **ports))


@pytest.mark.parametrize("kind", ["tcp", "pty"])
def test_on_a_port_of_its_own(kind, tmp_path):
    with served(**{kind: 0 if kind == "tcp" else str(tmp_path / "camera")}) as server:
        berth, = server.cameras
        watched = Watched(berth.place, power_off_at_end=True)
        watched.line.start()
        watched.until(lambda report: report.phase is CameraPhase.READY)
        with watched.line.using() as now:
            watched.line.session.look(-400, 100, now)
        watched.until(lambda report: (report.pan, report.tilt) == (-400, 100))
        assert watched.line.end(LIMIT) and not berth.camera.is_on
        watched.line.close()


def test_a_cable_that_is_pulled_and_a_port_that_is_not_there(tmp_path):
    watched = Watched(str(tmp_path / "camera"))
    watched.line.start()
    watched.until(lambda report: "no such port" in report.problem)
    with pytest.raises(RefusedError, match="no such port"), watched.line.using() as now:
        watched.line.session.home(now)
    with served(pty=str(tmp_path / "camera")) as server:
        watched.until(lambda report: report.phase is CameraPhase.READY)
        line = server.cameras[0].line
        with server.lock:
            line.plug(False)
        watched.until(lambda report: report.phase is CameraPhase.NO_LINE and report.problem != "")
        with server.lock:
            line.plug(True)
            server._watch(server.cameras[0], line)
        watched.until(lambda report: report.phase is CameraPhase.READY)
    assert watched.line.end(LIMIT)
    watched.line.close()


def test_each_of_several_robots_has_one_with_the_power_of_its_robot(tmp_path):
    with served(2, pty=str(tmp_path / "camera")) as server:
        assert [berth.place[-7:] for berth in server.cameras] == ["camera1", "camera2"]
        with server.lock:
            first, second = (berth.camera for berth in server.cameras)
            first.control(0)
            second.control(0)
            server.simulation.links[0].set_power(False)
            server.cameras[0].run_to(server.simulation.clock.now_us)
            server.simulation.links[0].set_power(True)
            server.cameras[0].run_to(server.simulation.clock.now_us)
        assert first.is_local and not second.is_local


def test_a_camera_whose_supply_fails_starts_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(session, "AGAIN", 0.2)
    with served(pty=str(tmp_path / "camera")) as server:
        watched = Watched(server.cameras[0].place)
        watched.line.start()
        watched.until(lambda report: report.phase is CameraPhase.READY)
        with server.lock:
            server.simulation.faults.add(fault_of("camera"), server.simulation.clock.now_us)
        server.wake()
        watched.until(lambda report: report.phase is CameraPhase.FAILED)
        with server.lock:
            assert server.cameras[0].camera.is_local and not server.cameras[0].camera.orders
            server.simulation.faults.clear(server.simulation.clock.now_us)
        watched.until(lambda report: report.phase is CameraPhase.READY)
        assert watched.line.end(LIMIT)
        watched.line.close()


def test_what_makes_no_sense_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="8103 is given as the port of a camera, but no camera"):
        camera_ports("none", "two_way", 1, 8103, None)
    with pytest.raises(ParameterError, match=r"\(8103\) or its pseudo-terminal \(/tmp/camera\), not both"):
        camera_ports("vcc4", "two_way", 1, 8103, "/tmp/camera")
    assert camera_ports("none", "two_way", 1, None, None) is None
    assert camera_ports("vcc4", "one_way", 2, None, None).camera().answers is False
    simulation = simulate(load_world("empty"), find_model("p3dx-sh"), 1, None, 0)
    with pytest.raises(ParameterError, match="cameras with a line of their own"):
        Server(simulation, tcp=0, lockstep=1.0, cameras=CameraPorts("vcc4", tcp=0))
    (tmp_path / "camera").write_text("")
    with pytest.raises(PortError):
        Server(simulation, tcp=0, cameras=CameraPorts("vcc4", pty=str(tmp_path / "camera")))
