"""The options of a flight's recording: `--record FILE --record-topic TOPIC`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from uwsim.base.options import option
from uwsim.flight.attachment import Attachment, AttachmentOptions, Departure


@dataclass(frozen=True)
class RecordOptions(AttachmentOptions):
    """The options of a recording."""

    switch = "record"

    record: Path | None = option(
        None, "Record the run into a new file: FILE.mcap, or FILE.bag for ROS 1 (no replay).", is_written=True
    )
    record_topic: tuple[str, ...] = option(
        (),
        "Channels to record, such as odom or 'camera/*'. Default: all but pictures and maps; of a survey, also without "
        "those derived from pings: scan, ping, laserPointCloud, points, depthArray, placed_ping, map_changes and "
        "octomap_binary.",
    )

    def attach(self, flight: Departure) -> Attachment:
        """Return the recorder of a flight. Raises ValueError."""
        from uwsim.recording.flight_recorder import recorder_of

        assert self.record is not None
        return recorder_of(flight, Path(self.record), tuple(self.record_topic) or None)
