"""Systems that test modules share: their loops are compiled once, as the numbers are given when they run."""

import fastaff as fa


def well(k=1.0, c=0.0):
    """x'' = -k x - c x^3."""
    return fa.hamiltonian("k*x**2/2 + c*x**4/4", coordinates="x", k=float(k), c=float(c))


def duffing(a=0.3, w=1.2, k=-1.0, c=1.0, mass=1.0):
    """mass x'' = -k x - c x^3 + a cos(w t)."""
    return fa.hamiltonian(
        "k*x**2/2 + c*x**4/4 - a*x*cos(w*t)",
        coordinates="x",
        masses=(float(mass),),
        period="2*pi/w",
        k=float(k),
        c=float(c),
        a=float(a),
        w=float(w),
    )


def oscillators(a=1.0, b=1.0, masses=(1.0, 1.0)):
    """Uncoupled oscillators: m_x x'' = -a x, m_y y'' = -b y."""
    return fa.hamiltonian("(a*x**2 + b*y**2)/2", masses=masses, a=float(a), b=float(b))
