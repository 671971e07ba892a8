#!/usr/bin/python3
"""Reference values for emg_test.cpp: ln of the EMG's density at u for mu = 0, sigma = 1, and its
first derivatives by mu, ln sigma (kappa = eta sigma held) and ln kappa, with 80 digits, by the
papers' formula as it stands.

    tests/eval/emg_reference.py > tests/eval/emg_reference.inc    (mpmath, Debian: python3-mpmath)
"""
import mpmath as mp

mp.mp.dps = 80
STEP = mp.mpf(10) ** -25  # differences are then exact to 50 digits


def log_density(x, mu, log_sigma, log_kappa):
    sigma = mp.e**log_sigma
    eta = mp.e**log_kappa / sigma
    s = (mu + eta * sigma**2 - x) / (mp.sqrt(2) * sigma)
    return mp.log(eta / 2) + eta / 2 * (2 * mu + eta * sigma**2 - 2 * x) + mp.log(mp.erfc(s))


def slope(x, parameters, k):
    up, down = list(parameters), list(parameters)
    up[k] += STEP
    down[k] -= STEP
    return (log_density(x, *up) - log_density(x, *down)) / (2 * STEP)


def text(value):
    return mp.nstr(mp.mpf(value), 20, min_fixed=1, max_fixed=0)


print("// Made by tests/eval/emg_reference.py: u, kappa, ln density, its derivatives.")
for kappa in (1e-6, 1e-3, 0.1, 1.0, 10.0, 17.0, 20.0, 40.0, 1e3, 1e6, 1e9, 1e12):
    parameters = (mp.mpf(0), mp.mpf(0), mp.log(mp.mpf(kappa)))
    for u in (-12, -3, -0.5, 0, 0.25, 2, 10, 40):
        values = [log_density(mp.mpf(u), *parameters)]
        values += [slope(mp.mpf(u), parameters, k) for k in range(3)]
        print("{" + ", ".join(text(value) for value in [u, kappa, *values]) + "},")
