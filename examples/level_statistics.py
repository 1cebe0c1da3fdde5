"""Level statistics of a neo-Hookean body from regular to chaotic energies, beside the chaos of its classical motion.

Thirteen spectra, each of one symmetry class (m, l) by itself, with the angular momenta p_eta = hbar (m - l)/2 = 0.3,
p_gamma = hbar (m + l)/2 = 0.2 or next to them: nine classes at hbar = 0.05 for high energies, four smaller hbar for low
ones. Classical orbits start at random points of the same energy surfaces, uniform in phase-space volume: their chaotic
share is the one in the theory of Berry and Robnik. About 3 minutes on two cores.
"""

import itertools
from functools import partial

import numpy as np
from matplotlib.figure import Figure

import fastaff
from fastaff.plot import plot_chaotic_fraction, plot_spacings

HBAR, ORBITS, TIME = 0.05, 300, 1200.0
NEIGHBOURS = [(a, b, HBAR, 250) for a in (5, 6, 7) for b in (3, 4, 5)]  # (m - l)/2, (m + l)/2, hbar, levels
FINE = [(3 * k, 2 * k, 0.1 / k, levels) for k, levels in ((4, 250), (5, 300), (6, 350), (7, 330))]
FIRST = 40  # lower levels have too few quanta for statistics
WINDOWS = np.array([0.7, 1.2, 1.6, 2.1, 2.6, 3.05, 3.45])
body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=2.0), mu=1.0)


def energy_surface(energy):
    """Draw orbits from the energy surfaces of the classes, uniform in volume: (alpha, beta) and the direction of motion
    are uniform.
    """
    random, parts, found = np.random.default_rng(1), [], 0
    while found < ORBITS:
        p_eta, p_gamma = HBAR * np.array(NEIGHBOURS)[random.integers(len(NEIGHBOURS), size=4000), :2].T
        alpha, beta = random.uniform(0.05, 4.0, (2, 4000))
        with np.errstate(invalid="ignore"):
            V = body.potential.value(alpha**2, beta**2) + ((p_eta / alpha) ** 2 + (p_gamma / beta) ** 2) / (2 * body.mu)
        inside = (alpha > beta) & (energy > V)
        p, angle = np.sqrt(2 * body.mu * np.maximum(energy - V, 0)), random.uniform(0, 2 * np.pi, 4000)
        z = np.array(
            [alpha, 0 * alpha, beta, 0 * beta, p * np.cos(angle), p_eta / alpha, p * np.sin(angle), p_gamma / beta]
        )
        parts.append(z[:, inside])
        found += np.count_nonzero(inside)
    return body, np.concatenate(parts, axis=1)[:, :ORBITS]


spectra, unfolded, deviations = [], [], []
for a, b, hbar, size in NEIGHBOURS + FINE:
    m, l = a + b, b - a
    levels = fastaff.quantum.spectrum(body, m=m, l=l, count=size, hbar=hbar, tolerance=1e-6)
    count = partial(fastaff.quantum.weyl_count, body, m=m, l=l, hbar=hbar)
    deviation = fastaff.quantum.count_deviation(levels.E, count)
    spectra.append(levels.E)
    unfolded.append(fastaff.quantum.unfold(levels.E, count))
    deviations.append(deviation)
    print(
        f"(m, l) = ({m:2d}, {l:2d}), hbar = 1/{1 / hbar:.0f}: {size} levels to E = {levels.E[-1]:.3f}, error "
        f"{levels.error.max():.0e}; "
        f"staircase less Weyl: first half {deviation[: size // 2].mean():+.3f}, second half "
        f"{deviation[size // 2 :].mean():+.3f}, "
        f"rms {deviation.std():.2f}"
    )

centres = (WINDOWS[1:] + WINDOWS[:-1]) / 2
chaos = fastaff.chaotic_fraction(energy_surface, (centres,), names=("energy",), time=TIME, early_stop=True)
expected = [fastaff.quantum.BerryRobnik(float(q)).mean_ratio() for q in chaos.fraction]
ratios, spacings = [], []
for low, high in itertools.pairwise(WINDOWS):
    inside = [(np.arange(E.size) >= FIRST) & (np.abs(E - (low + high) / 2) < (high - low) / 2) for E in spectra]
    chosen = [(E[kept], x[kept]) for E, x, kept in zip(spectra, unfolded, inside) if np.count_nonzero(kept) > 2]
    ratios.append(fastaff.quantum.mean_spacing_ratio([E for E, _ in chosen]))
    spacings.append(np.concatenate([np.diff(x) for _, x in chosen]))
for k, (low, high, ratio, theory, s) in enumerate(zip(WINDOWS, WINDOWS[1:], ratios, expected, spacings)):
    fit = fastaff.quantum.fit_spacings(s, fastaff.quantum.BerryRobnik)
    print(
        f"E = {low:.2f} ... {high:.2f}: {ratio.ratios} ratios, <r> = {ratio.value:.4f} +- {ratio.error:.4f}; "
        f"{chaos.shares.of(k).fraction_text()}, "
        f"which gives {theory:.4f}; fitted to P(s) {fit.law.chaotic:.3f} ({fit.low:.3f} ... {fit.high:.3f}); mean "
        f"spacing {s.mean():.3f}"
    )

figure = Figure(figsize=(13.5, 7.2), dpi=160, layout="constrained")
axes = figure.subplot_mosaic([["a", "b", "c"], ["d", "d", "e"]])
axes["a"].errorbar(
    centres,
    [r.value for r in ratios],
    xerr=np.diff(WINDOWS) / 2,
    yerr=[r.error for r in ratios],
    fmt="o",
    ms=4,
    color="#b35900",
    capsize=2,
    elinewidth=1,
    label="levels",
)
axes["a"].plot(centres, expected, color="#00306f", lw=1.3, label="Berry-Robnik, classical share (b)")
for value, name in ((fastaff.quantum.POISSON_RATIO, "Poisson"), (fastaff.quantum.GOE_RATIO, "GOE")):
    axes["a"].axhline(value, color="0.4", lw=0.9, ls=(0, (4, 3)))
    axes["a"].text(WINDOWS[0], value + 0.002, name, fontsize=9, color="0.3")
axes["a"].set(ylabel=r"mean ratio of spacings $\langle r\rangle$", xlabel="energy $E/G$", ylim=(0.31, 0.56))
axes["a"].legend(frameon=False, loc="lower right", fontsize=9)
plot_chaotic_fraction(chaos, ax=axes["b"])
axes["b"].set(xlabel="energy $E/G$", ylabel="chaotic share of the energy surface")
for levels, deviation in zip(spectra, deviations):
    axes["d"].plot(levels, deviation, lw=0.5, color="#00306f", alpha=0.35)
grid = np.linspace(WINDOWS[0], WINDOWS[-1], 60)
near = [[d[np.abs(E - e) < 0.15] for E, d in zip(spectra, deviations) if E[-1] > e + 0.15] for e in grid]
kept = [e for e, parts in zip(grid, near) if parts]
axes["d"].plot(
    kept,
    [np.mean(np.concatenate(parts)) for parts in near if parts],
    color="#b35900",
    lw=2,
    label=r"mean, $\Delta E = 0.3$",
)
axes["d"].axhline(0.0, color="black", lw=0.8)
axes["d"].set(
    xlabel="energy $E/G$", ylabel="$N(E) - N_\\mathrm{Weyl}(E)$", ylim=(-2.4, 2.4), xlim=(spectra[-1][0], WINDOWS[-1])
)
axes["d"].legend(frameon=False, loc="lower left", fontsize=9)
calm, wild = int(np.argmin(chaos.fraction)), int(np.argmax(chaos.fraction))
for ax, chosen in ((axes["c"], calm), (axes["e"], wild)):
    q = float(chaos.fraction[chosen])
    laws = {"Poisson": fastaff.quantum.BerryRobnik(0.0), "GOE (Wigner)": fastaff.quantum.BerryRobnik(1.0)}
    if 0.01 < q < 0.99:
        laws[f"Berry-Robnik, share {q:.2f}"] = fastaff.quantum.BerryRobnik(q)
    plot_spacings(spacings[chosen], laws, ax=ax, label=f"{spacings[chosen].size} spacings")
    ax.legend(frameon=False, fontsize=9)
titles = {"a": "levels", "b": "classical orbits", "d": "staircase less Weyl count: no level is missing"}
for key, k in (("c", calm), ("e", wild)):
    titles[key] = f"${WINDOWS[k]:g} < E < {WINDOWS[k + 1]:g}$, chaotic share {chaos.fraction[k]:.2f}"
for key, title in titles.items():
    axes[key].set_title(f"{key}   {title}", loc="left", fontsize=10)
figure.supxlabel(
    rf"neo-Hookean body, $G=\mu=1$, $K=2$, $p_\eta\approx0.3$, $p_\gamma\approx0.2$; {len(spectra)} spectra, each of "
    rf"one class $(m,l)$, "
    rf"{sum(E.size for E in spectra)} levels, $\hbar=1/20\ldots1/70$; {ORBITS} orbits for each energy",
    fontsize=8,
    color="0.3",
)
figure.savefig("level_statistics.png")
