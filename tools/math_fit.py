#!/usr/bin/env python3
"""Prints the coefficients that math.h (acos) and math_normal.cpp (inverse_normal_cdf) hold, with their errors.

Polynomials and quotients that meet the function at Chebyshev nodes, solved with 60 digits. Needs mpmath; the build does
not run it.
"""
from mpmath import asin, cos, erfc, exp, log, lu_solve, matrix, mp, mpf, ncdf, npdf, pi, polyval, sqrt

mp.dps = 60


def fit(f, a, b, num, den):
    """Coefficients, lowest power first, of the quotient of degrees num and den that equals f at Chebyshev nodes."""
    n = num + den + 1
    nodes = [(a + b) / 2 + (b - a) / 2 * cos(pi * (2 * k + 1) / (2 * n)) for k in range(n)]
    lhs, rhs = matrix(n, n), matrix(n, 1)
    for i, x in enumerate(nodes):
        rhs[i] = f(x)
        for j in range(num + 1):
            lhs[i, j] = x**j
        for j in range(1, den + 1):
            lhs[i, num + j] = -rhs[i] * x**j
    c = list(lu_solve(lhs, rhs))
    return c[: num + 1], [mpf(1)] + c[num + 1 :]


def value(pq, x):
    return polyval(pq[0][::-1], x) / polyval(pq[1][::-1], x)


def quantile(p):
    """Inverse normal CDF by Halley's iteration."""
    x = -sqrt(-2 * log(p)) if p < 0.05 else (p - mpf(1) / 2) * sqrt(2 * pi)
    for _ in range(100):
        step = ((ncdf(x) if x > -5 else erfc(-x / sqrt(2)) / 2) - p) / npdf(x)
        step /= 1 + x * step / 2
        x -= step
        if abs(step) < mpf(10) ** -50 * abs(x):
            break
    return x


def show(name, f, a, b, num, den, weight):
    a, b = mpf(a), mpf(b)
    pq = fit(f, a, b, num, den)
    points = [a + (b - a) * (2 * k + 1) / 1000 for k in range(500)]
    print(f"{name}: error {mp.nstr(max(abs((value(pq, x) - f(x)) * weight(x)) for x in points), 2)}")
    for part in pq if den else pq[:1]:
        print("  {" + ", ".join(mp.nstr(c, 17, min_fixed=-3, max_fixed=6) for c in part) + "}")


def central(w):
    q = sqrt(mpf("0.180625") - w)
    return -quantile(mpf(1) / 2 - q) / q


relative_to = lambda f: lambda x: 1 / f(x)
tail = lambda r: quantile(exp(-r * r / 2))
show("acos: (asin(sqrt z) / sqrt z - 1) / z", lambda z: (asin(sqrt(z)) / sqrt(z) - 1) / z, 0, "0.25", 11, 0, lambda z: z)
show("centre: x / q of 0.425^2 - q^2, q = p - 1/2", central, 0, "0.180624999", 7, 7, relative_to(central))
for low, high in (("2.27", "5"), ("5", "12"), ("12", "39")):
    show(f"tail: x of sqrt(-2 log p) in [{low}, {high}]", tail, low, high, 7, 7, relative_to(tail))
