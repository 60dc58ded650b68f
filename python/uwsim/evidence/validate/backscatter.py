"""Backscatter of seabeds compared with the published table, and its curves beside Lambert's law."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from uwsim.evidence.validate.check import Check, within
from uwsim.figures.style import save_figure
from uwsim.instruments.acoustics import seabed_backscatter_db
from uwsim.scenario.spec.material import BACKSCATTER

GRAZING_DEG = (1, 2, 3, 5, 7, 10, 20, 40, 60, 70, 80, 85, 88, 89, 90)
TABLE_SPEED_M_S = 1528.0
TABLE_DB = {
    ("rough_rock", 30e3): (
        -23.0, -19.4, -17.4, -14.8, -13.3, -11.3, -7.9, -5.4, -4.9, -5.0, -5.4, -5.3, -5.4, -5.4, -5.4,
    ),
    ("rock", 30e3): (
        -44.0, -37.3, -33.3, -28.4, -25.2, -21.7, -15.4, -10.0, -9.1, -8.3, -7.3, -6.8, -6.6, -6.6, -6.6,
    ),
    ("cobble", 30e3): (
        -48.5, -41.7, -37.6, -32.6, -29.2, -25.7, -19.3, -14.9, -13.1, -11.5, -9.2, -8.2, -7.9, -7.9, -7.8,
    ),
    ("sandy_gravel", 30e3): (
        -50.3, -44.2, -40.3, -35.1, -31.7, -28.1, -22.1, -18.9, -16.5, -13.7, -9.9, -8.4, -8.0, -7.9, -7.8,
    ),
    ("coarse_sand", 30e3): (
        -47.1, -43.8, -41.5, -37.9, -34.9, -31.5, -25.1, -21.4, -18.8, -15.3, -8.9, -5.6, -4.6, -4.4, -4.4,
    ),
    ("medium_sand", 10e3): (
        -61.5, -56.8, -53.2, -47.6, -43.4, -38.8, -30.9, -24.4, -22.6, -20.4, -13.2, -5.0, 1.2, 2.3, 2.6,
    ),
    ("medium_sand", 30e3): (
        -51.4, -48.1, -45.8, -42.1, -39.0, -35.4, -28.3, -23.5, -21.2, -17.7, -10.8, -5.5, -3.4, -3.1, -3.1,
    ),
    ("medium_sand", 100e3): (
        -50.0, -44.9, -41.5, -36.6, -33.3, -29.8, -24.2, -21.7, -19.5, -16.4, -12.2, -10.4, -9.8, -9.7, -9.7,
    ),
    ("very_fine_sand", 30e3): (
        -59.7, -54.7, -50.8, -44.6, -40.1, -35.2, -27.1, -24.9, -23.7, -23.1, -20.2, -13.1, -5.9, -4.3, -3.8,
    ),
    ("very_fine_sand", 100e3): (
        -51.4, -47.9, -45.4, -41.3, -37.9, -34.0, -27.0, -24.8, -23.5, -22.3, -18.0, -12.9, -10.3, -10.0, -10.0,
    ),
    ("sandy_mud", 30e3): (
        -58.2, -51.1, -46.6, -41.3, -38.3, -35.7, -31.8, -28.8, -27.4, -27.0, -26.3, -23.9, -13.1, -6.8, -3.6,
    ),
}  # fmt: skip
"""APL-UW TR 9407 (1994), table 3, printed to 0.1 dB, as transcribed by the tests of uacpy (a public package)."""
TOLERANCE_DB = 0.1
SUSPECT = {("rough_rock", 30e3): (7, 80), ("rock", 30e3): (40,), ("medium_sand", 10e3): (1,)}
"""Cells that differ by 0.2 to 0.6 dB from a curve that their neighbours match to the printed digit, presumably by an
error in the print or its transcription. Their tolerance is 0.6 dB."""
SUSPECT_DB = 0.6


def checks() -> list[Check]:
    """Check the cell that differs most in each column of the table, and the worst of the suspect cells."""
    found = []
    for (name, frequency_hz), published_db in TABLE_DB.items():
        got_db = seabed_backscatter_db(name, np.radians(GRAZING_DEG), frequency_hz, TABLE_SPEED_M_S)
        suspects = SUSPECT.get((name, frequency_hz), ())
        for suspect, tolerance_db in ((False, TOLERANCE_DB), (True, SUSPECT_DB)):
            cells = [k for k, angle in enumerate(GRAZING_DEG) if (angle in suspects) is suspect]
            if cells:
                worst = max(cells, key=lambda k: abs(float(got_db[k]) - published_db[k]))
                what = f"{name}, {frequency_hz / 1e3:g} kHz, {GRAZING_DEG[worst]} deg" + (
                    " (suspect)" if suspect else ""
                )
                expected, got = published_db[worst], float(got_db[worst])
                found.append(within("backscatter, TR 9407", what, expected, got, 1.0, tolerance_db, "dB"))
    return found


def draw(path: Path) -> None:
    """Draw the curves at 30 kHz with the table's cells, and Lambert's law with the strengths of our materials."""
    figure, panel = plt.subplots(figsize=(9, 6), layout="constrained", dpi=120)
    angles_rad = np.radians(np.linspace(0.5, 90.0, 400))
    names = [name for name, frequency_hz in TABLE_DB if frequency_hz == 30e3]
    for k, name in enumerate(names):
        colour = f"C{k}"
        level_db = seabed_backscatter_db(name, angles_rad, 30e3, TABLE_SPEED_M_S)
        panel.plot(np.degrees(angles_rad), level_db, "-", c=colour, label=name.replace("_", " "))
        panel.plot(GRAZING_DEG, TABLE_DB[name, 30e3], "o", ms=4, mfc="none", c=colour)
    for material, style in (("rock", "--"), ("sand", "-."), ("mud", ":")):
        lambert_db = BACKSCATTER[material].strength_db + 20.0 * np.log10(np.sin(angles_rad))
        panel.plot(np.degrees(angles_rad), lambert_db, style, c="0.5", label=f"Lambert, our {material}")
    panel.set(
        xlabel="grazing angle [deg]", ylabel="backscatter [dB per m²]", ylim=(-65, 5), title="APL-UW TR 9407, 30 kHz"
    )
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8, ncols=2)
    save_figure(figure, path)
    plt.close(figure)
