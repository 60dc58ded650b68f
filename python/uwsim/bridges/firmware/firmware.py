"""A compiled ArduSub as a child process: started in a folder of its own, and ended with this process in any case."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import BinaryIO, NamedTuple, Self

from uwsim.base.atomic_file import write_atomically
from uwsim.base.folder_lock import alone_in
from uwsim.base.own_files import mark, require_own
from uwsim.mapping.files.georeference import Home

PATIENCE_S = 1.0  # for a firmware that is asked to end
OUTPUT, PARAMETERS = "ardusub.txt", "uwsim.parm"
SERIALS, RC_PORT = 9, 5501
PR_SET_PDEATHSIG = 1  # prctl(2)
LIBC = ctypes.CDLL(None)
NAVIGATION: Mapping[str, float] = MappingProxyType(
    {
        "GPS1_TYPE": 0,
        "VISO_TYPE": 1,
        "EK3_SRC1_POSXY": 6,
        "EK3_SRC1_VELXY": 6,
        "EK3_SRC1_POSZ": 1,
        "EK3_SRC1_VELZ": 0,
        "EK3_SRC1_YAW": 1,
        "RNGFND1_TYPE": 100,
        "RNGFND1_ORIENT": 25,
        "RNGFND1_MIN": 0.1,
        "RNGFND1_MAX": 50,
    }
)
"""External position and velocity, depth from the barometer, heading from the compass, range from this simulator."""
SIMULATED: Mapping[str, float] = MappingProxyType(
    {
        "BATT_MONITOR": 4,
        "LOG_DISARMED": 1,  # otherwise a log begins at arming, for which the firmware waits a time that varies
    }
)
"""Settings for the simulated battery and for logs that do not depend on the wall clock."""


class FirmwareError(OSError):
    """Raised for a firmware that cannot be started, or that has ended."""


class Serials(NamedTuple):
    """UDP addresses to which the firmware's first two serial ports send MAVLink: ground station, navigation."""

    station: str
    navigation: str


class Firmware:
    """Runs an ArduSub that was compiled for simulation (SITL), within a `with` statement.

        with ArduSub(sim, port=0) as ardusub, Firmware(binary, ardusub.port, serials, home) as firmware: ...

    binary: its path. port: UDP port of the physics. serials: where its MAVLink goes. home: where the world's origin is.
    files: parameter files, of which later ones take precedence. parameters: these take precedence over all files.
    folder: keeps its parameters (eeprom.bin) and logs; by default, a temporary folder. system: its MAVLink system id.

    It has no other serial ports, so it listens only for RC input, by UDP on port rc_port of all addresses, and for the
    physics' answers, at a free one. No other run can use the folder, and no file in it that uwsim did not write is
    replaced. The firmware is killed when this process ends, however that happens. Raises FirmwareError.
    """

    def __init__(
        self,
        binary: Path,
        port: int,
        serials: Serials,
        home: Home,
        *,
        files: Sequence[Path] = (),
        parameters: Mapping[str, float] = MappingProxyType({}),
        folder: Path | None = None,
        system: int = 1,
        rc_port: int = RC_PORT,
    ) -> None:
        self.binary = checked_program(binary)
        self.files = [_listed(path) for path in files]
        self.parameters = dict(parameters)
        self._folder, self.system = folder, system
        self._options = {
            "model": "JSON:127.0.0.1", "sim-port-out": port, "speedup": 1, "rate": 400, "sysid": system,
            "rc-in-port": rc_port, "start-time": 1600000000, "home": f"{home.lat_deg},{home.lon_deg},0,0",
            "serial0": f"udpclient:{serials.station}", "serial1": f"udpclient:{serials.navigation}",
            **{f"serial{number}": "none:" for number in range(2, SERIALS)},
        }  # fmt: skip
        self._process: subprocess.Popen[bytes] | None = None
        self._stack = ExitStack()
        self.folder = Path()

    @property
    def pid(self) -> int:
        """Its process id. Raises FirmwareError if it does not run."""
        if self._process is None:
            raise FirmwareError(f"{self.binary}: has not been started")
        return self._process.pid

    def require_running(self) -> None:
        """Raise FirmwareError, with its last line, if the firmware has ended."""
        code = None if self._process is None else self._process.poll()
        if code is None:
            return
        how = f"exit code {code}" if code >= 0 else f"signal {-code} ({signal.Signals(-code).name})"
        what = f"{self.binary}: the firmware of system {self.system}"
        raise FirmwareError(f"{what} has ended with {how}{_last_words(self.folder / OUTPUT)}")

    def __enter__(self) -> Self:
        with ExitStack() as made:
            self.folder = self._own_folder(made)
            lines = (f"{name} {value:.9g}\n" for name, value in self.parameters.items())
            output = self._written_files("".join(lines), made)
            defaults = ",".join([*map(str, self.files), PARAMETERS])  # the second is in its working directory
            words = [f"--{name}={value}" for name, value in {**self._options, "defaults": defaults}.items()]
            parent = os.getpid()
            try:
                self._process = subprocess.Popen(
                    [str(self.binary), *words], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=output,
                    stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=lambda: end_with_parent(parent),
                )  # fmt: skip
            except OSError as error:  # such as a file of another architecture
                raise FirmwareError(f"{self.binary}: cannot be started: {error.strerror}") from None
            made.callback(self._end)
            self._stack = made.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the firmware, and delete a temporary folder."""
        self._stack.close()

    def _own_folder(self, made: ExitStack) -> Path:
        if self._folder is None:
            return Path(made.enter_context(tempfile.TemporaryDirectory(prefix="ardusub-")))
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FirmwareError(f"{self._folder}: {error.strerror}") from None
        try:
            made.enter_context(alone_in(self._folder, "--ardusub-folder"))
        except OSError as error:
            raise FirmwareError(str(error)) from None
        return self._folder.resolve()

    def _written_files(self, parameters: str, made: ExitStack) -> BinaryIO:
        """Write the parameters, and return the file of the firmware's output. Both are marked as our own."""
        path = self.folder / OUTPUT
        try:
            require_own(path)
            write_atomically(self.folder / PARAMETERS, parameters.encode())
            output = path.open("wb")
        except OSError as error:
            raise FirmwareError(str(error)) from None
        mark(path, unfinished=True)
        made.callback(mark, path)
        return made.enter_context(output)

    def _end(self) -> None:
        assert self._process is not None
        self._process.terminate()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:  # it waits for a line, and heeds nothing else
            self._process.kill()
            self._process.wait()


def end_with_parent(parent: int) -> None:
    """Let the kernel kill this process when the thread that has started it ends. parent: its process id."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def checked_program(path: Path) -> Path:
    """Return the resolved path of a program. Raises FirmwareError for a file that cannot be started."""
    found = _readable(path)
    if not os.access(found, os.X_OK):
        raise FirmwareError(f"{path}: is not executable: run chmod +x")
    return found


def _readable(path: Path) -> Path:
    found = path.expanduser()
    if not found.is_file():
        raise FirmwareError(f"{path}: {'is no file' if found.exists() else 'no such file'}")
    if not os.access(found, os.R_OK):
        raise FirmwareError(f"{path}: permission denied")
    return found.resolve()


def _listed(path: Path) -> Path:
    found = _readable(path)
    if "," in str(found):
        raise FirmwareError(f"{found}: must contain no comma, with which ArduSub separates files")
    return found


def _last_words(path: Path) -> str:
    lines = [line.strip() for line in path.read_text(errors="replace").splitlines()] if path.exists() else []
    spoken = [line for line in lines if line]
    return f": {spoken[-1]}" if spoken else ""
