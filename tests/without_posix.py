"""Take from dnanalyze and its tests what only POSIX has: ``pytest -p tests.without_posix``.

Other packages keep it, as on a system without it they have means of their own.
"""

import builtins
import os
import signal
import sys
from types import ModuleType

OURS = ("dnanalyze", "tests", "test_", "conftest")
MODULES = {"fcntl", "grp", "pwd", "pty", "resource", "termios", "tty"}
ATTRIBUTES = {
    "os": {
        "chown", "fchmod", "fchown", "fork", "forkpty", "getegid", "geteuid", "getgid",
        "getgroups", "getloadavg", "getpgid", "getpriority", "getuid", "getsid", "killpg", "lchown",
        "mkfifo", "mknod", "nice", "openpty", "posix_fadvise", "posix_spawn", "pread", "preadv",
        "pwrite", "readv", "sched_getaffinity", "sched_setaffinity", "setpgid", "setpriority",
        "setsid", "statvfs", "sysconf", "sync", "uname", "wait3", "wait4", "waitpid", "writev",
    },
    "signal": {
        "SIGALRM", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGPROF", "SIGQUIT", "SIGUSR1", "SIGUSR2",
        "alarm", "pause", "pthread_kill", "pthread_sigmask", "setitimer", "siginterrupt", "sigwait",
    },
}  # fmt: skip


def ours(frame: object) -> bool:
    """Whether a frame runs code of dnanalyze or of its tests."""
    return str(frame.f_globals.get("__name__", "")).startswith(OURS)


class Lacking(ModuleType):
    """A module without some attributes, as seen from our own code."""

    def __getattribute__(self, name):
        known = ATTRIBUTES[ModuleType.__getattribute__(self, "__name__")]
        if name in known and ours(sys._getframe(1)):
            raise AttributeError(f"no {name} on this system")
        return ModuleType.__getattribute__(self, name)


def lacking_import(name, globals=None, *rest, real=builtins.__import__, **more):
    """``__import__`` that finds none of the modules for our own code."""
    if name in MODULES and str((globals or {}).get("__name__", "")).startswith(OURS):
        raise ModuleNotFoundError(f"no {name} on this system", name=name)
    return real(name, globals, *rest, **more)


os.__class__ = Lacking
signal.__class__ = Lacking
builtins.__import__ = lacking_import
