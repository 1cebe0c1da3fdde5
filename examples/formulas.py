"""Systems of the literature in one line each: conserved quantities, a section and frequencies of each.

A formula is compiled to the same kernels as a hand-written model; its parameters stay run-time values.
"""

import numpy as np

import fastaff

henon_heiles = fastaff.hamiltonian("(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)", lam=1.0)
toda = fastaff.hamiltonian("(exp(2*y + 2*sqrt(3)*x) + exp(2*y - 2*sqrt(3)*x) + exp(-4*y))/24 - 1/8")
contopoulos = fastaff.hamiltonian("(A*x**2 + B*y**2)/2 - eps*x*y**2", A=1.6, B=0.9, eps=0.08)
barbanis = fastaff.hamiltonian("(x**2 + y**2)/2 + k*x**2*y", k=0.3)
galaxy = fastaff.hamiltonian("v0**2/2*log(Rc**2 + x**2 + y**2/q**2)", v0=1.0, Rc=0.14, q=0.9)
fpu = fastaff.hamiltonian(
    "(q1**2 + (q2 - q1)**2 + (q3 - q2)**2 + (q4 - q3)**2 + q4**2)/2"
    " + alpha/3*(q1**3 + (q2 - q1)**3 + (q3 - q2)**3 + (q4 - q3)**3 - q4**3)",
    coordinates="q1 q2 q3 q4",
    alpha=0.25,
)

planar = {
    "Henon-Heiles": (henon_heiles, 0.1),
    "Toda": (toda, 0.5),
    "Contopoulos": (contopoulos, 0.3),
    "Barbanis": (barbanis, 0.3),
    "logarithmic galaxy": (galaxy, -0.3),
}
section = fastaff.Hyperplane(normal=(1, 0, 0, 0))
for name, (model, energy) in planar.items():
    start = fastaff.energy_grid(model, energy=energy, section=section, axes=(np.linspace(-0.2, 0.3, 9), [0.0, 0.15])).z0
    found = fastaff.poincare_map(model, start, section=section, crossings=100, max_time=2000.0, step=0.03)
    found.raise_if_failed()
    nu = fastaff.frequency_map(model, start[:, :4], time=400.0, step=0.03).nu
    ratio = ", ".join(f"{r:.4f}" for r in nu[1] / nu[0])
    print(f"{name}: {found.counts.sum()} crossings, energy error {found.energy_error.max():.1e}; nu_y/nu_x = {ratio}")


def toda_integral(z):
    """Return the third integral of the Toda lattice (Henon 1974, Phys. Rev. B 9, 1921)."""
    x, y, px, py = z
    s = np.sqrt(3.0)
    wings = (px + s * py) * np.exp(2 * y - 2 * s * x) + (px - s * py) * np.exp(2 * y + 2 * s * x)
    return 8 * px * (px**2 - 3 * py**2) + wings - 2 * px * np.exp(-4 * y)


start = np.random.default_rng(1).uniform(-0.4, 0.4, (4, 100))
end = fastaff.integrate(toda, start, time=500.0, step=0.02).z
print(
    f"Toda: the third integral of 100 orbits changed by {np.abs(toda_integral(end) - toda_integral(start)).max():.1e} "
    "in time 500"
)

# Energy in the lowest mode of a chain of four: it comes and goes (Fermi, Pasta & Ulam 1955).
k = np.arange(1, 5)
modes, omega = np.sqrt(0.4) * np.sin(np.pi * np.outer(k, k) / 5), 2 * np.sin(np.pi * k / 10)
chain = fastaff.integrate(fpu, np.concatenate([modes[0] * 1.5, np.zeros(4)]), time=400.0, step=0.05, samples=8)
energies = ((chain.samples[:, 4:, 0] @ modes) ** 2 + (omega * (chain.samples[:, :4, 0] @ modes)) ** 2) / 2
for t, row in zip(chain.times, energies):
    print(f"FPU, t = {t:5.1f}: energies of the modes " + "  ".join(f"{e:.4f}" for e in row))

# A body in a field of gravity along y, with unequal inertia: four degrees of freedom, nothing isotropic.
body = fastaff.affine_body("C/2*(D1**2 + D2**2) + C/(D1*D2) - g*y", C=1.0, g=0.2, mu=(1.0, 1.5))
run = fastaff.integrate(body, [1.5, 0.1, 0.2, 0.0, 0.1, 0.2, 0.1, 0.3], time=200.0)
print(f"{body}: energy error {run.energy_error[0]:.1e}")
