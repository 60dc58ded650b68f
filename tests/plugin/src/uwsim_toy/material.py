"""The material `maerl`: a bed of red algae's skeletons, hard and rough."""

from __future__ import annotations

from uwsim.scenario.spec.material import SEABEDS, Backscatter, MaterialKind

MAERL = MaterialKind(Backscatter(strength_db=-28.0, relief=0.12, fluid=SEABEDS["sandy_gravel"]), looks="gravel")
