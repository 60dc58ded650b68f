"""The vehicle coefficients as printed in their sources, independent of the YAML files that the simulator reads."""

from __future__ import annotations

from dataclasses import replace

from uwsim.evidence.validate.motion.reference_solution import Coefficients

BLUEROV2_HEAVY = Coefficients(
    mass_kg=13.5,
    volume_m3=0.0134,
    inertia_kg_m2=(0.26, 0.23, 0.37),
    added_mass=(6.3567, 7.1206, 18.6863, 0.1858, 0.1348, 0.2215),
    linear_damping=(13.7, 0.0, 33.0, 0.0, 0.8, 0.0),
    quadratic_damping=(141.0, 217.0, 190.0, 1.192, 0.470, 1.5),
    centre_of_buoyancy_m=(0.0, 0.0, 0.01),
    munk_share=0.0,
    crossflow_length_m=0.457,
    source="von Benzon et al. 2022, J. Mar. Sci. Eng. 10:1898",
)

BLUEROV2_HEAVY_CFD = replace(
    BLUEROV2_HEAVY,
    linear_damping=(0.388, 0.0, 0.0, 0.0, 0.8, 0.0),
    quadratic_damping=(36.25, 129.7, 243.3, 1.192, 0.470, 4.86),
    source="surge: BlueROV2-CFD-analysis 2026; sway, heave, yaw: Li et al. 2020, JMSE 8:688; else as above",
)

BLUEROV2_WU = Coefficients(
    mass_kg=11.2,
    volume_m3=0.0113459,
    inertia_kg_m2=(0.16, 0.16, 0.16),
    added_mass=(5.5, 12.7, 14.57, 0.12, 0.12, 0.12),
    linear_damping=(4.03, 6.22, 5.18, 0.07, 0.07, 0.07),
    quadratic_damping=(18.18, 21.66, 36.99, 1.55, 1.55, 1.55),
    centre_of_buoyancy_m=(0.0, 0.0, 0.02),
    munk_share=0.0,
    crossflow_length_m=0.457,
    source="Wu 2018, Flinders University, as used by OsloMet OceanLab; volume of MarineGym; mass assumed",
)

BLUEROV2_TANK = Coefficients(
    mass_kg=11.4,
    volume_m3=0.0115,
    inertia_kg_m2=(0.21, 0.245, 0.245),
    added_mass=(2.6, 18.5, 13.3, 0.054, 0.0173, 0.28),
    linear_damping=(0.09, 0.26, 0.19, 0.895, 0.287, 4.64),
    quadratic_damping=(34.96, 103.25, 74.23, 0.084, 0.028, 0.43),
    centre_of_buoyancy_m=(0.0, 0.0, 0.02),
    munk_share=0.0,
    crossflow_length_m=0.457,
    source="Nan Fernandez-Ayala 2025, bluerov2_dynamics, fossen/parameters.py; centre of buoyancy assumed",
)

# Fossen models the hull as a spheroid; damping in sway, heave, pitch and yaw is its cross-flow drag (Prestero 2001,
# derived by Ariza Ramirez 2018).
REMUS_100 = Coefficients(
    mass_kg=31.03,
    volume_m3=31.03 / 1026,
    inertia_kg_m2=(0.11202, 4.0278, 4.0278),
    added_mass=(0.84, 29.4, 29.4, 0.0336, 3.43, 3.43),
    linear_damping=(0.0, 0.0, 0.0, 0.59, 10.8, 0.0),
    quadratic_damping=(6.11, 171.5, 171.5, 0.0, 22.0, 22.0),
    centre_of_mass_m=(0.0, 0.0, -0.02),
    water_density_kg_m3=1026.0,
    source="Fossen, PythonVehicleSimulator, vehicles/remus100.py",
)

PUBLISHED = {
    "bluerov2_heavy": BLUEROV2_HEAVY,
    "bluerov2_heavy_cfd": BLUEROV2_HEAVY_CFD,
    "bluerov2_wu": BLUEROV2_WU,
    "bluerov2_tank": BLUEROV2_TANK,
    "remus100": REMUS_100,
}
