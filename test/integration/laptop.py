"""Runs a program as on a laptop with Windows and little but Python: without what only POSIX systems have.

    python3 laptop.py [--without MODULE] -m MODULE [ARGUMENT ...]
    python3 laptop.py [--without MODULE] -c CODE

What is hidden cannot be imported or called. What is left of `select` and `os` refuses what Windows refuses.
"""

# Only modules that load nothing of what is hidden: so that `socket` and `selectors` see what is left when they load.
import _socket
import os
import select
import signal
import stat
import sys
from functools import partial

MODULES = ("termios", "fcntl", "pty", "tty", "grp", "pwd", "resource", "syslog", "readline")
NAMES = {
    os: "O_CLOEXEC O_NOCTTY O_NONBLOCK fork forkpty geteuid getgid getpgid getpgrp getppid getuid kill killpg mkfifo "
        "mknod nice openpty pipe2 posix_spawn pread pwrite readv sched_getaffinity sched_yield sendfile set_blocking "
        "setsid setuid sysconf ttyname writev",
    select: "epoll kqueue poll",
    signal: "SIGALRM SIGHUP SIGUSR1 SIGUSR2 alarm pause pthread_kill setitimer sigwait",
    _socket: "AF_UNIX CMSG_LEN socketpair",
}
"""Names of modules that are deleted, as far as this system has them."""


class Hidden:
    """A finder of modules that finds none of ``names``."""

    def __init__(self, names):
        self._names = names

    def find_spec(self, name, path=None, target=None):
        """Raise ImportError for a hidden module, and leave all others to the next finder."""
        if name.partition(".")[0] in self._names:
            raise ImportError("No module named %r on this laptop" % name, name=name)


def hide(*others):
    """Hide all of the above and the modules ``others``, from now on and for all of this process."""
    names = {*MODULES, *others}
    for name in [name for name in sys.modules if name.partition(".")[0] in names]:
        del sys.modules[name]
    sys.meta_path.insert(0, Hidden(names))
    for module, words in NAMES.items():
        for word in words.split():
            if hasattr(module, word):
                delattr(module, word)
    os.read, os.write = partial(not_for_sockets, os.read), partial(not_for_sockets, os.write)
    select.select = WindowsSelect(select.select)


def is_socket(file):
    """Return whether a file, or the number of one, is a socket."""
    return stat.S_ISSOCK(os.fstat(file if isinstance(file, int) else file.fileno()).st_mode)


def not_for_sockets(function, descriptor, what):
    """Call a function of ``os``, but refuse a socket: on Windows its number is not that of a file."""
    if is_socket(descriptor):
        raise OSError(9, "Bad file descriptor")
    return function(descriptor, what)


class WindowsSelect:
    """select() as on Windows. It is an object, so that it is no method of a class that has it, as a builtin is none."""

    def __init__(self, select):
        self._select = select

    def __call__(self, *arguments, **options):
        return only_for_sockets(self._select, *arguments, **options)


def only_for_sockets(wait, readers, writers, others, timeout=None):
    """Call select(), but refuse all but sockets, and refuse to wait for nothing."""
    files = [*readers, *writers, *others]
    if not files or not all(map(is_socket, files)):
        raise OSError(10022, "An invalid argument was supplied")
    return wait(readers, writers, others, timeout)


def main(arguments):
    """Hide, and run the module or the code."""
    without = []
    while arguments[0] == "--without":
        without.append(arguments[1])
        arguments = arguments[2:]
    hide(*without)
    how, what, *rest = arguments
    sys.argv = [what, *rest]
    if how == "-m":
        import runpy

        runpy.run_module(what, run_name="__main__", alter_sys=True)
    else:
        exec(compile(what, "<laptop>", "exec"), {"__name__": "__main__"})


if __name__ == "__main__":
    main(sys.argv[1:])
