"""Other people's readers of files in a contained process: they read much, but may crash, hang, or do as a file asks.

`run_contained` runs the function `read` of a script in a process that has no environment and cannot start programs,
open sockets, change other processes, or open files other than those that it needs. Landlock and seccomp see to that,
and a warning names the one that a kernel lacks; memory, time and the size of files are limited on every kernel. This
file is also the program of that process; to start quickly, it must not import uwsim.
"""

from __future__ import annotations

import ctypes
import importlib.util
import io
import json
import os
import resource
import signal
import stat
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

MEMORY_BYTES, MEMORY_PER_BYTE, CPU_S = 2_000_000_000, 20, 8
"""Limits for a small file, and the allowance per byte of a larger one. A BlueROV2 mesh of 5 MB takes a second."""
WALL_PER_CPU_S = 10
"""Seconds that a process may last for each that it may compute: it shares the machine, or waits in vain."""
LIBRARIES = (sys.prefix, sys.base_prefix, str(Path(__file__).parents[2]), "/usr", "/lib", "/lib64", "/etc/ld.so.cache")
SYSTEM = ("/dev/null", "/dev/urandom", "/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/sys/devices/system")
DENIED = """execve execveat fork vfork tkill ptrace process_vm_readv process_vm_writev pidfd_open pidfd_getfd socket
    io_uring_setup bpf perf_event_open userfaultfd keyctl add_key request_key mount umount2 chroot unshare setns chmod
    fchmod fchmodat fchmodat2 chown lchown fchown fchownat setxattr lsetxattr fsetxattr utime utimes utimensat"""
READ_FILE, READ_DIR, WRITES = 1 << 2, 1 << 3, sum(1 << bit for bit in (1, 4, 5, 7, 8, 14))
"""Landlock's rights; the last are to write, remove, make and empty files and folders."""
CLONE_THREAD, EQUAL_MASKED, NOT_EQUAL, TSYNC, ALLOW, ERRNO = 0x10000, 7, 1, 4, 0x7FFF0000, 0x00050000


def run_contained(
    script: Path, reader: str, *arguments: Any, reads: Sequence[Path], cpu_s: int = CPU_S, cpu_s_per_byte: float = 1e-6
) -> dict[str, NDArray[Any]]:
    """Return the arrays by name that `read` of a script returns for arguments in JSON.

    reader: the library that it uses, for messages. reads: the files and folders that it needs, that of most bytes
    first. cpu_s, cpu_s_per_byte: the processor time that it may take. Raises ValueError with the reason if it failed,
    OSError for a file that is not regular.
    """
    from uwsim.base.npz import read_npz
    from uwsim.base.texts.text_file import require_regular

    files = [each for each in reads[0].iterdir() if not each.is_dir()] if reads[0].is_dir() else [reads[0]]
    for path in files:
        require_regular(path)
    size = sum(path.stat().st_size for path in files)
    memory_bytes, cpu_s = MEMORY_BYTES + MEMORY_PER_BYTE * size, cpu_s + round(cpu_s_per_byte * size)
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder)
        asked = json.dumps([str(script), arguments, [*map(str, reads)], folder, memory_bytes, cpu_s])
        kept = {name: value for name, value in os.environ.items() if name in ("LD_LIBRARY_PATH", "LD_PRELOAD")}
        environment = {**kept, "TMPDIR": folder, "OPENBLAS_NUM_THREADS": "1"}  # other threads would not be contained
        with (own / "out").open("w+b") as out, (own / "err").open("w+b") as err:
            command, wall_s = [sys.executable, "-I", __file__, asked], WALL_PER_CPU_S * cpu_s
            try:
                code = subprocess.run(
                    command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, env=environment, timeout=wall_s
                ).returncode
            except subprocess.TimeoutExpired:
                raise ValueError(f"{reader} had not read it after {wall_s} s") from None
            if (own / "lacking").exists():
                warnings.warn(f"{reader} was contained without {(own / 'lacking').read_text()}", stacklevel=2)
            out.seek(0)
            err.seek(max(err.seek(0, os.SEEK_END) - 10_000, 0))
            made, lines = out.read(), err.read().decode(errors="replace").strip().splitlines()
    if code == -signal.SIGXCPU:
        raise ValueError(f"{reader} had not read it after {cpu_s} s")
    if code == -signal.SIGKILL:  # which no limit of ours sends
        raise ValueError(f"{reader} was killed while it read it: this machine has too little memory")
    if code < 0:
        raise ValueError(f"{reader} crashed on it ({signal.Signals(-code).name})")
    if code:
        raise ValueError(lines[-1] if lines else f"{reader} gave up")
    return read_npz(made, memory_bytes)


def _lock_files(reads: Sequence[str], folder: str) -> bool:
    """Restrict the files that this process opens by Landlock; return whether the kernel has it."""
    libc = ctypes.CDLL(None, use_errno=True)
    version = libc.syscall(444, None, 0, 1)
    if version < 1:
        return False
    rights = (1 << {1: 13, 2: 14, 3: 15, 4: 15}.get(version, 16)) - 1
    handled = (ctypes.c_uint64 * 3)(rights, 3, 3)  # TCP and signals, too
    rules = libc.syscall(444, handled, ctypes.c_size_t(8 if version < 4 else 16 if version < 6 else 24), 0)
    for path in (*LIBRARIES, *SYSTEM, *reads, folder):
        try:
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        except OSError:
            continue
        allowed = (READ_FILE | READ_DIR | (WRITES if path == folder else 0)) & rights
        if not stat.S_ISDIR(os.fstat(place).st_mode):
            allowed &= READ_FILE
        rule = allowed.to_bytes(8, sys.byteorder) + place.to_bytes(4, sys.byteorder)
        libc.syscall(445, rules, 1, rule, 0)
        os.close(place)
    return bool(libc.prctl(38, 1, 0, 0, 0) == 0 and libc.syscall(446, rules, 0) == 0)


class _Compared(ctypes.Structure):
    """libseccomp's scmp_arg_cmp."""

    _fields_ = (
        ("arg", ctypes.c_uint),
        ("op", ctypes.c_int),
        ("datum_a", ctypes.c_uint64),
        ("datum_b", ctypes.c_uint64),
    )


def _lock_calls() -> bool:
    """Deny this process other programs, processes, sockets and files' modes; return whether libseccomp could do it."""
    try:
        library = ctypes.CDLL("libseccomp.so.2")
    except OSError:
        return False
    library.seccomp_init.restype = ctypes.c_void_p
    rules, own = ctypes.c_void_p(library.seccomp_init(ALLOW)), os.getpid()
    compared: dict[str, _Compared | None] = dict.fromkeys(DENIED.split())
    compared["clone"] = _Compared(0, EQUAL_MASKED, CLONE_THREAD, 0)
    compared.update(dict.fromkeys(("kill", "tgkill"), _Compared(0, NOT_EQUAL, own)))
    compared["prlimit64"] = _Compared(2, NOT_EQUAL, 0)
    compared["setrlimit"] = compared["clone3"] = None
    done: int = library.seccomp_attr_set(rules, TSYNC, 1)
    for name, of in compared.items():
        error = ERRNO | (38 if name == "clone3" else 1)  # the C library then uses clone
        if (number := library.seccomp_syscall_resolve_name(name.encode())) != -1:
            done |= library.seccomp_rule_add_array(rules, error, number, int(of is not None), of and ctypes.byref(of))
    done |= library.seccomp_load(rules)
    return done == 0


def main() -> None:
    """Run a script's function within its limits; on error, print one line to stderr and exit with code 1."""
    script, arguments, reads, folder, *limits = json.loads(sys.argv[1])  # noqa: TID251  # our own
    memory_bytes, cpu_s = limits
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # keeps the libraries' output out of the result
    spec = importlib.util.spec_from_file_location("contained_script", script)
    assert spec is not None and spec.loader is not None
    module = sys.modules["contained_script"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    for kind, limit in (
        (resource.RLIMIT_AS, taken + memory_bytes),
        (resource.RLIMIT_FSIZE, memory_bytes),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 256),
    ):
        resource.setrlimit(kind, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 1))  # SIGXCPU; at the second, SIGKILL
    locks = {"Landlock (it could read other files)": _lock_files(reads, folder), "seccomp": _lock_calls()}
    if lacking := [name for name, locked in locks.items() if not locked]:
        Path(folder, "lacking").write_text(" and ".join(lacking))
    try:
        np.savez(content := io.BytesIO(), **module.read(*arguments))
        out.write(content.getvalue())
        out.close()
    except MemoryError:
        sys.exit(f"takes more than {memory_bytes / 1e9:.1f} GB to read")
    except Exception as error:  # the libraries raise errors of any type for malformed files
        sys.exit(" ".join(str(error).split())[:1000] or type(error).__name__)


if __name__ == "__main__":
    main()
