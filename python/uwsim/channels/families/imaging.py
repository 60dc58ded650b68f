"""Imaging sonar channels: echo levels, and pictures for an operator. VIEWS maps each kind of sonar to a class.

Like camera pictures, pings are computed in parallel with the steps. The picture of a side-scan or profiling sonar
combines several pings, which its view stores.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import LATE, PICTURE, PING, Channel, Delivery, OverLink
from uwsim.channels.delivery.pictures import RATE_HZ, Part, Pictures, Stream, as_jpeg
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.instruments.sonars.imaging import ForwardLooking, Profiles, SideScan, SingleBeam, SonarImage, Waterfall
from uwsim.instruments.sonars.imaging.pixels import in_colours, polar_pixels, shown_range
from uwsim.instruments.sonars.mounted import ImagingSonar
from uwsim.simulator.simulator import Simulator

Levels = NDArray[np.float32]
DTYPE_FLOAT32 = 8  # SonarImageData.DTYPE_FLOAT32
HEIGHT = 400  # pixels
WATERFALL_PINGS = 300
SWEEP_RAD = np.radians(60.0)  # to each side
SWEEP_STEP_RAD = np.radians(2.0)
SOUND_SPEED_M_S = 1500.0


@dataclass(frozen=True)
class Echoes:
    """The result of a ping for a view. level_db: (bins, beams).

    bearings_rad: about the sonar's z axis, positive to port. draw: draws the picture (h, w, 3), as it was at
    the time of the ping.
    """

    level_db: Levels
    bearings_rad: NDArray[np.float64]
    ranges_m: NDArray[np.float64]
    draw: Callable[[], NDArray[np.uint8]]


class Look:
    """The result of one reading, whose picture is drawn only if it is read.

    sound_speed_m_s: the speed of sound at the sonar, as its own probe would measure it.
    """

    def __init__(self, time_ns: int, echoes: Echoes, stream: Stream, sound_speed_m_s: float) -> None:
        self.time_ns, self.echoes, self.sound_speed_m_s = time_ns, echoes, sound_speed_m_s
        self._stream = stream
        self._jpeg: bytes | None = None

    def __contains__(self, part: Part) -> bool:
        return self._jpeg is not None

    def part(self, part: Part) -> bytes:
        """Return the picture as JPEG; it is the only part."""
        if self._jpeg is None:
            self._jpeg = as_jpeg(self.echoes.draw(), self._stream)
        return self._jpeg


class View(Protocol):
    """Produces the results of one kind of sonar for display. rate_hz: their default rate."""

    rate_hz: float

    def begin(self, sonar: ImagingSonar, time_ns: int) -> Callable[[], Echoes]:
        """Capture the state; return a function that computes the echoes."""


class Ahead:
    """A forward-looking sonar: each ping is a picture."""

    rate_hz = 5.0

    def begin(self, sonar: ImagingSonar, time_ns: int) -> Callable[[], Echoes]:
        """See View."""
        ping = sonar.later()

        def look() -> Echoes:
            image: SonarImage = ping()
            model = image.model

            def draw() -> NDArray[np.uint8]:
                limits = shown_range(image.level_db, image.noise_db[:, None])
                fan = polar_pixels(image.level_db, model.range_max_m, model.field_of_view_rad, HEIGHT)
                return in_colours(fan.level_db, limits)

            return Echoes(image.level_db, image.bearings_rad, image.ranges_m, draw)

        return look


class Aside:
    """A side-scan sonar.

    The picture is a waterfall of recent pings, with the latest at the top and port on the left.
    """

    rate_hz = RATE_HZ

    def __init__(self) -> None:
        self._rows: deque[tuple[int, Levels]] = deque(maxlen=WATERFALL_PINGS)

    def begin(self, sonar: ImagingSonar, time_ns: int) -> Callable[[], Echoes]:
        """See View."""
        ping = sonar.later()

        def look() -> Echoes:
            line: Waterfall = ping()
            while self._rows and self._rows[0][0] >= time_ns:
                self._rows.popleft()  # simulated time went back
            row = _coarser(line.picture_db(), 2 * HEIGHT)[0]
            if self._rows and len(self._rows[0][1]) != len(row):
                self._rows.clear()  # the sonar's parameters have changed
            self._rows.appendleft((time_ns, row))
            shown = [row for _, row in self._rows]

            def draw() -> NDArray[np.uint8]:
                rows = np.stack(shown)
                noise_db = _coarser(np.concatenate([line.noise_db[::-1], line.noise_db])[None], 2 * HEIGHT)
                picture_db = np.full((WATERFALL_PINGS, rows.shape[1]), np.nan, np.float32)
                picture_db[: len(rows)] = rows
                return in_colours(picture_db, shown_range(rows, noise_db))

            levels = np.stack([line.starboard_db[0], line.port_db[0]], axis=1)
            return Echoes(levels, np.array([-0.5 * np.pi, 0.5 * np.pi]), line.ranges_m, draw)

        return look


class Across:
    """A profiling sonar, whose motor steps its beam back and forth. The picture shows the last echo in each direction.

    In each period of 1 / RATE_HZ, the sonar pings as often as the travel time of sound allows.
    """

    rate_hz = RATE_HZ

    def __init__(self) -> None:
        count = round(2 * SWEEP_RAD / SWEEP_STEP_RAD) + 1
        self._angles_rad = np.linspace(-SWEEP_RAD, SWEEP_RAD, count)
        self._order = np.concatenate([np.arange(count), np.arange(count - 2, 0, -1)])
        self._columns: Levels | None = None

    def begin(self, sonar: ImagingSonar, time_ns: int) -> Callable[[], Echoes]:
        """See View."""
        pings = max(int(SOUND_SPEED_M_S / (2 * sonar.model.range_max_m * RATE_HZ)), 1)
        first = int(time_ns * RATE_HZ // 1_000_000_000) * pings
        steps = self._order[(first + np.arange(min(pings, len(self._angles_rad)))) % len(self._order)]
        ping = sonar.later(self._angles_rad[steps])

        def look() -> Echoes:
            found: Profiles = ping()
            noise_db = _coarser(found.noise_db[None], HEIGHT)
            if self._columns is None or self._columns.shape[1] != noise_db.shape[1]:
                self._columns = np.repeat(noise_db, len(self._angles_rad), axis=0)
            self._columns[steps] = _coarser(found.level_db, HEIGHT)
            columns = self._columns.copy()

            def draw() -> NDArray[np.uint8]:
                fan = polar_pixels(columns.T, found.model.range_max_m, 2 * SWEEP_RAD, HEIGHT)
                picture = in_colours(fan.level_db, shown_range(columns, noise_db))
                return picture[::-1]  # its x axis points down

            return Echoes(found.level_db.T, found.angles_rad, found.bin_centres_m, draw)

        return look


def picture_geometry(model: Any) -> dict[str, Any]:
    """Return the shape, range and angle of an imaging sonar's picture, for drawing range rings and bearings over it."""
    if isinstance(model, SideScan):
        return {"shape": "waterfall", "range_m": model.range_max_m, "fov_rad": 0.0}
    if isinstance(model, SingleBeam):
        return {"shape": "fan_down", "range_m": model.range_max_m, "fov_rad": 2 * float(SWEEP_RAD)}
    return {"shape": "fan", "range_m": model.range_max_m, "fov_rad": model.field_of_view_rad}


VIEWS: dict[type, Callable[[], View]] = {ForwardLooking: Ahead, SideScan: Aside, SingleBeam: Across}


def imaging_channels(source: Source, sim: Simulator, pictures: Pictures) -> list[Channel]:
    """Return the echo-level and picture channels of a vehicle's imaging sonars."""
    found = []
    for name, sonar in source.of(sim).imaging_sonars.items():
        topic, frame_id = source.topic(name), source.frame(f"{name}_link")
        view = next(view for model, view in VIEWS.items() if isinstance(sonar.model, model))()
        pictures.set_stream(topic, Stream(rate_hz=view.rate_hz))
        read = _reader(source, name, view, pictures)
        found += [
            Channel(
                f"{topic}/image", "marine_acoustic_msgs/msg/ProjectedSonarImage", "out",
                "levels [dB re 1 uPa] by beam and range", rate_hz=view.rate_hz, frame_id=frame_id,
                over_link=OverLink(PING, ""), delivery=LATE, read=_message_of(read, None, frame_id, _levels(sonar)),
            ),
            Channel(
                f"{topic}/picture/compressed", "sensor_msgs/msg/CompressedImage", "out",
                "a picture of its echoes as JPEG", rate_hz=view.rate_hz, frame_id=frame_id,
                over_link=OverLink(PICTURE, "thumbnail"),
                delivery=Delivery(late=True, pieced=not isinstance(sonar.model, ForwardLooking)),
                read=_message_of(read, "drawn", frame_id, _picture),
            ),
        ]  # fmt: skip
    return found


Read = Callable[[Simulator, "Part | None"], "Look | None"]


def _reader(source: Source, name: str, view: View, pictures: Pictures) -> Read:
    def read(sim: Simulator, part: Part | None) -> Look | None:
        time_ns = sim.time_ns

        def begin(stream: Stream) -> Callable[[], Look]:
            sonar = source.of(sim).imaging_sonars[name]
            make = view.begin(sonar, time_ns)
            speed_m_s = sim.world.water.sound_speed_m_s(min(float(sonar.world_from_sonar[2, 3]), 0.0))
            return lambda: Look(time_ns, make(), stream, speed_m_s)

        found: Look | None = pictures.read_made(sim, source.topic(name), begin, part)
        return found

    return read


def _message_of(look: Read, part: Part | None, frame_id: str, write: Callable[[Look, str], Any]) -> Any:
    def read(sim: Simulator) -> Any:
        seen = look(sim, part)
        return None if seen is None else write(seen, frame_id)

    return read


def _picture(look: Look, frame_id: str) -> Any:
    return build.message(
        "sensor_msgs/msg/CompressedImage",
        header=build.header(look.time_ns, frame_id),
        format="rgb8; jpeg compressed bgr8",
        data=np.frombuffer(look.part("drawn"), np.uint8),
    )


def _levels(sonar: ImagingSonar) -> Callable[[Look, str], Any]:
    def write(look: Look, frame_id: str) -> Any:
        model: Any = sonar.model
        echoes = look.echoes
        across_rad = getattr(model, "beam_width_rad", None) or model.along_width_rad
        along_rad = getattr(model, "vertical_width_rad", across_rad)
        beams = len(echoes.bearings_rad)
        info = build.message(
            "marine_acoustic_msgs/msg/PingInfo",
            frequency=model.frequency_hz,
            sound_speed=look.sound_speed_m_s,
            rx_beamwidths=np.full(beams, across_rad, np.float32),
            tx_beamwidths=np.array([along_rad], np.float32),
        )
        image = build.message(
            "marine_acoustic_msgs/msg/SonarImageData",
            dtype=DTYPE_FLOAT32,
            beam_count=beams,
            data=np.ascontiguousarray(echoes.level_db, "<f4").view(np.uint8).ravel(),
        )
        return build.message(
            "marine_acoustic_msgs/msg/ProjectedSonarImage",
            header=build.header(look.time_ns, frame_id),
            ping_info=info,
            # x is up and z ahead, so y is to starboard; bearings increase to port.
            beam_directions=[build.vector((0.0, -np.sin(angle), np.cos(angle))) for angle in echoes.bearings_rad],
            ranges=echoes.ranges_m.astype(np.float32),
            image=image,
        )

    return write


def _coarser(level_db: Levels, width: int) -> Levels:
    """Average the power of adjacent columns of levels (rows, columns), to reduce them to about `width` columns."""
    together = -(-level_db.shape[1] // width)
    columns = level_db.shape[1] // together
    power = 10.0 ** (level_db[:, : columns * together].astype(np.float64) / 10.0)
    mean = power.reshape(len(power), columns, together).mean(axis=2)
    return np.asarray(10.0 * np.log10(np.maximum(mean, 1e-30)), np.float32)
