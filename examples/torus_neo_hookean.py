"""A torus of the neo-Hookean body, which separates in no coordinates: fitted from one orbit, with its actions and a
section.

Shows the section of the torus with p_alpha = 0 as its Fourier series predicts it, over the crossings of orbits that
poincare_map finds, and how the residual of the equations of motion on the torus falls with the order of the series.
"""

import numpy as np
from matplotlib.figure import Figure

import fastaff

body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=2.0), mu=1.0)
section = fastaff.AlphaTurning(direction=+1)
grid = fastaff.energy_grid(
    body, energy=1.0, p_eta=0.3, p_gamma=0.2, section=section, axes=([0.2, 0.35, 0.5, 0.65], [0.0])
)
fits = [fastaff.fit_torus(body, z0, time=1000.0) for z0 in grid.z0.T]
for fit in fits:
    print(fit.summary())
    print("   J =", ", ".join(f"{name} {J:.10f}" for name, J in zip(fit.names, fit.J)))
    if fit.classification is fastaff.Classification.REGULAR:
        print(f"   J_eta/2 pi - p_eta = {fit.I[-2] - 0.3:.1e}, J_gamma/2 pi - p_gamma = {fit.I[-1] - 0.2:.1e}")


def predicted(fit, circles=240, nodes=49):
    """Return beta, p_beta where the torus meets the section, increasing: on circles of one libration angle, then of the
    other.

    Arcs end where the torus touches the section and its function starts to decrease instead.
    """
    met = []
    for along, across in ((0, 1), (1, 0)):
        theta = np.zeros((4, circles, nodes))
        theta[along], theta[across] = np.linspace(0.0, 1.0, nodes), np.linspace(0.0, 1.0, circles)[:, None]
        above = section(fit.evaluate(theta)) >= 0
        i, j = np.nonzero(above[:, :-1] != above[:, 1:])
        low, high, first = theta[:, i, j], theta[:, i, j + 1], above[i, j]
        for _ in range(30):
            middle = (low + high) / 2
            same = (section(fit.evaluate(middle)) >= 0) == first
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        ahead = 1e-4 * fit.nu[:, None]
        increasing = section(fit.evaluate(high + ahead)) > section(fit.evaluate(high - ahead))
        met.append(fastaff.charts.ALPHA_BETA.from_planes(fit.evaluate(high[:, increasing]))[[1, 5]])
    return np.concatenate(met, axis=1)


found = fastaff.poincare_map(body, grid.z0, section=section, crossings=60, max_time=1000.0)
beta, p_beta = found["beta"], found["p_beta"]

figure = Figure(figsize=(10, 4.6), dpi=200, layout="constrained")
left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
colours = ("#00204d", "#7c7b78", "#bc5a00", "#2a788e")
orders = np.array([2, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 56, 72])
for fit, colour, x, y, marker in zip(fits, colours, beta.T, p_beta.T, "osD^"):
    left.plot(*predicted(fit.truncated(20)), ".", markersize=1.2, color=colour)
    left.plot(x, y, marker, markersize=4.5, markerfacecolor="none", markeredgewidth=0.7, color=colour)
    residuals = [fit.truncated(order).residual for order in orders[orders <= fit.order]]
    right.semilogy(
        orders[: len(residuals)], residuals, marker + "-", markersize=4, linewidth=1, color=colour, label=f"{x[0]:.2f}"
    )
left.set_xlabel(r"$\beta$")
left.set_ylabel(r"$p_\beta$")
left.set_title("section $p_\\alpha = 0$: series (dots), orbit (open); arcs end where the torus touches it", fontsize=9)
right.set_xlabel(r"order: largest $\sum_i |k_i|$ that is kept")
right.set_ylabel("residual of the invariance equation")
right.set_title("convergence", fontsize=10)
right.legend(title=r"$\beta$ of the first crossing", fontsize=9, title_fontsize=9)
figure.savefig("torus_neo_hookean.png")
