"""asammdf beside timonel: frames of six PGNs, recorded in MF4, to columns by a DBC. The tests do without it.

    .venv/bin/python -m pip install asammdf==8.8.28      # and what it needs
    .venv/bin/python -m benchmarks.decode                # then has its rows

The DBC has the six PGNs alone, as single frames are all that asammdf puts into columns.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.recordings import SHARED
from timonel.recording.frames import Frames

try:
    import asammdf
except ImportError:
    asammdf = None

DBC = SHARED / "tools" / "peers" / "peers" / "n2k6.dbc"
_COLUMNS = [("BusChannel", "<u1"), ("ID", "<u4"), ("IDE", "<u1"), ("DLC", "<u1"), ("DataLength", "<u1"),
            ("DataBytes", "(8,)u1"), ("Dir", "<u1"), ("EDL", "<u1"), ("BRS", "<u1"), ("ESI", "<u1")]  # fmt: skip
_ROW = np.dtype([(f"CAN_DataFrame.{name}", kind) for name, kind in _COLUMNS])


def six_to_columns(frames: Frames, folder: Path) -> Callable[[], int]:
    """What makes columns of the frames, which were recorded before; it returns how many values they have."""
    path = folder / "six.mf4"
    _record(frames, path)
    recording = asammdf.MDF(path)

    def run() -> int:
        found = recording.extract_bus_logging({"CAN": [(str(DBC), 0)]})
        count = 0
        for number, group in enumerate(found.groups):
            for channel in range(1, len(group.channels)):
                count += len(found.get(group=number, index=channel).samples)
        return count

    return run


def _record(frames: Frames, path: Path) -> None:
    rows: Any = np.zeros(len(frames), _ROW)
    rows["CAN_DataFrame.BusChannel"] = rows["CAN_DataFrame.IDE"] = 1
    rows["CAN_DataFrame.ID"] = frames.identifier & 0x1FFFFFFF
    rows["CAN_DataFrame.DLC"] = rows["CAN_DataFrame.DataLength"] = frames.length
    rows["CAN_DataFrame.DataBytes"] = frames.data
    blocks = asammdf.blocks
    constants = blocks.v4_constants
    source = blocks.source_utils.Source("CAN", "CAN", "CAN", constants.SOURCE_BUS, constants.BUS_TYPE_CAN)
    times = (frames.stamp - frames.stamp[0]) / 1e9
    recording = asammdf.MDF(version="4.10")
    recording.append(asammdf.Signal(rows, times, name="CAN_DataFrame", source=source))
    recording.groups[-1].channel_group.flags |= constants.FLAG_CG_BUS_EVENT
    recording.save(path, overwrite=True)
    recording.close()
