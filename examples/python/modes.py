"""Modes of triangles in memory: a wedge of glass.

    python3 modes.py
"""
import carillon as ca

wedge = ca.Object(
    vertices=[[0, 0, 0], [0.1, 0, 0], [0, 0.06, 0], [0, 0, 0.04]],  # m
    faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], name="wedge")
modes = wedge.modes("glass", max_frequency="100 kHz", max_modes=5, pitch_cents="off")

for frequency, cents in zip(modes.frequencies, modes.errors):
    print(f"{frequency:10.2f} Hz, within {cents:.2g} cents")
