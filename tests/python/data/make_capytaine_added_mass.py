"""Write capytaine_added_mass.json: what Capytaine computes for the hulls of `uwsim validate peers`, mesh by mesh.

    pip install capytaine==3.0.0
    python tests/python/data/make_capytaine_added_mass.py

It needs 6 GB, and about a minute for each mesh of 5000 panels.
"""

import json
import time

import capytaine
import numpy as np

from uwsim.evidence.validate.peers.added_mass import HULLS, LEVELS, RESULTS

DENSITY_KG_M3 = 1000.0


def added_mass(vertices_m: np.ndarray, triangles: np.ndarray) -> list[float]:
    """Return the diagonal of the added mass about the origin in unbounded water, a panel for each triangle."""
    mesh = capytaine.Mesh(vertices=vertices_m, faces=np.c_[triangles, triangles[:, 2]])
    body = capytaine.FloatingBody(mesh, dofs=capytaine.rigid_body_dofs(rotation_center=(0, 0, 0)))
    solver = capytaine.BEMSolver()
    found = []
    for dof in body.dofs:
        problem = capytaine.RadiationProblem(
            body=body, radiating_dof=dof, free_surface=np.inf, omega=1.0, rho=DENSITY_KG_M3
        )
        found.append(float(f"{solver.solve(problem).added_masses[dof]:.6g}"))
    return found


if __name__ == "__main__":
    results = {name: [added_mass(*mesh(level)) for level in LEVELS] for name, mesh in HULLS.items()}
    head = {"capytaine": capytaine.__version__, "date": time.strftime("%Y-%m-%d"), "density_kg_m3": DENSITY_KG_M3}
    rows = (
        f"  {json.dumps(name)}: [\n   " + ",\n   ".join(map(json.dumps, each)) + "\n  ]"
        for name, each in results.items()
    )
    text = json.dumps(head, indent=1)[:-2] + ',\n "added_mass": {\n' + ",\n".join(rows) + "\n }\n}\n"
    RESULTS.write_text(text)
