"""A sound from modes that were stored before.

    carillon modes bowl -m ceramic -o bowl.h5 && python3 sound.py bowl.h5 ceramic bowl.wav
"""
import sys

import carillon as ca

if len(sys.argv) != 4:
    sys.exit("usage: sound.py MODES.h5 MATERIAL OUT.wav")
stored, material, output = sys.argv[1:]
modes = ca.Modes.load(stored, material)
sound = modes.strike(impulse=0.01, contact_time=0.5e-3, seed=0)  # N s, s
sound.save(output)
print(f"{output}: {sound.document['modes']} of {len(modes)} modes sound")
