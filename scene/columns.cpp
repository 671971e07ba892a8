#include "scene/columns.hpp"

namespace carillon::scene {

namespace {

constexpr bool may_be_nan = true;

constexpr core::ColumnRule list[] = {
    // Of every sample.
    {"audio", "", "audio", "m/s|Pa", "always", "`gain` applied; int16: full scale 1.0 is 32,768"},
    {"mel", "float32", "mel", "power", "mel", "the definition's parameters are attributes"},
    {"key", "text", "", "1", "always", "`shape/material/size/strike-NNNN`, or `simulation-NNNN`"},
    {"id", "uint64", "", "1", "always", "first 8 bytes of the key's SHA-256"},
    {"shape", "text", "", "1", "always", "label; of a simulation all that play, joined by commas"},
    {"family", "text", "", "1", "struck", "label"},
    {"material", "text", "", "1", "always",
     "label; of a simulation all that play, joined by commas"},
    {"label_", "text", "", "1", "may",
     "`label_NAME`: what a manifest's column NAME says of the object; empty for objects without"},
    {"size", "float64", "", "1", "struck", "label: factor of the shape's lengths"},
    {"strike", "int64", "", "1", "struck", "label: number of the strike on its shape"},
    {"split_shape", "text", "", "1", "always",
     "`train`, `validation` or `test`, frozen: whole shapes held out, simulations as wholes"},
    {"split_strike", "text", "", "1", "always",
     "the same: strikes held out within each shape, simulations as wholes"},
    {"position", "float64", "3", "m", "struck", "point struck, in the object's coordinates"},
    {"normal", "float64", "3", "1", "struck", "outward normal there"},
    {"direction", "float64", "3", "1", "struck", "way of the force"},
    {"impulse", "float64", "", "N s", "struck",
     "of the contact force: a raised cosine, or with `striker` as it follows from the striker (of "
     "a "
     "noise burst the integral of its force, random and of either sign)"},
    {"contact_time", "float64", "", "s", "struck",
     "of the contact force (of a noise burst its whole length); 0 with `effects.contact: off`, an "
     "ideal impulse"},
    {"strike_times", "float64", "strikes", "s", "may",
     "when the strikes of the clip are, ascending; those before it begins are negative; NaN: no "
     "more",
     may_be_nan},
    {"gain", "float64", "", "s/m|1/Pa", "always", "recorded level"},
    {"peak", "float64", "", "1", "always", "largest magnitude before int16 rounds and clips"},
    {"clipped", "int64", "", "1", "always", "samples clipped"},
    {"modes", "int64", "", "1", "struck", "modes that sound"},
    {"modes_above_nyquist", "int64", "", "1", "struck",
     "modes of the band that oscillate at or above half the sample rate and are left out; 0 where "
     "the band ends below it, as it does by default"},
    {"complete_to", "float64", "", "Hz", "struck", "no mode below this frequency is missing"},
    {"pitch_error", "float64", "", "cent", "struck",
     "largest estimated pitch error of the modes in this material and size"},
    {"youngs_modulus", "float64", "", "Pa", "struck",
     "of the material (first of several regions; the isotropic mean of an anisotropic one)"},
    {"poisson_ratio", "float64", "", "1", "struck",
     "of the material (first of several regions; the isotropic mean of an anisotropic one)"},
    {"density", "float64", "", "kg/m^3", "struck", "of the material (first of several regions)"},
    {"damping_model", "text", "", "1", "struck",
     "`rayleigh`, `caughey`, `power`, `hybrid` or `expression` (`dataset.json` has the formula)"},
    {"alpha", "float64", "", "", "struck",
     "`alpha1`, `alpha2`, ...: as many as the build's damping models need, at least two; NaN where "
     "a model has fewer; unit `SI` where models of the build differ in it",
     may_be_nan},

    // Effects of struck objects.
    {"negative_damping_modes", "int64", "", "1", "may",
     "modes whose damping model was negative (`negative_damping: clamp` or `drop`)"},
    {"negative_damping_low", "float64", "", "Hz", "may", "lowest of these modes; NaN: none",
     may_be_nan},
    {"negative_damping_high", "float64", "", "Hz", "may", "highest of these modes; NaN: none",
     may_be_nan},
    {"striker", "text", "", "1", "striker", "its kind"},
    {"striker_speed", "float64", "", "m/s", "striker", "at the contact; 0 for a noise burst"},
    {"striker_effective_mass", "float64", "", "kg", "striker",
     "of striker and object together, as Hertz's contact has it; 0 for a noise burst"},
    {"striker_effective_radius", "float64", "", "m", "striker",
     "of striker and object together, as Hertz's contact has it; 0 for a noise burst"},
    {"striker_peak_force", "float64", "", "N", "striker",
     "largest magnitude of the force as it is rendered: Hertz's pulse, the raised cosine in its "
     "place, or the noise burst"},
    {"striker_hardness", "float64", "", "1", "striker", "of a noise burst; 0 for other kinds"},
    {"striker_size", "float64", "", "1", "striker", "of a noise burst; 0 for other kinds"},
    {"radiation_residual", "float64", "", "1", "may",
     "largest of the modes: normal velocity that the radiation model leaves, over the mode's"},
    {"radiation_decay_rate", "float64", "", "1/s", "may",
     "largest of the modes: what radiation adds to the material's decay rate"},
    {"radiation_doubtful_modes", "int64", "", "1", "may",
     "modes whose residual is above 0.3; kept or silent as `radiation.doubtful` says"},
    {"support_force", "float64", "contacts", "N", "struck:supports",
     "of each point, patch, base or line, in the order of the configuration"},
    {"support_position", "float64", "contacts,3", "m", "struck:supports",
     "their centres, from the centre of the object's box"},
    {"support_damping", "float64", "", "1/s", "struck:supports",
     "largest gain of a mode's decay rate, without coupling"},
    {"support_index", "int64", "contacts", "1", "may",
     "which place of its pool each contact is, from 0; -1: one that has no pool "
     "(`supports.contacts[].pool`)"},
    {"support_coupled", "int64", "", "1", "may",
     "1: the coupled modes sound; 0: they could not be found, and the diagonal answer does "
     "(`supports.coupling: full`)"},
    {"support_modes", "int64", "", "1", "may", "modes of the object (`supports.coupling: full`)"},
    {"support_modes_compared", "int64", "", "1", "may",
     "those of them that can be compared with the diagonal answer"},
    {"support_decay_error", "float64", "", "1", "may",
     "largest relative error of a decay rate in the diagonal answer; NaN: none can be compared",
     may_be_nan},
    {"support_pitch_error", "float64", "", "cent", "may",
     "largest pitch error in the diagonal answer; NaN: none can be compared", may_be_nan},
    {"support_decay_error_estimate", "float64", "", "1", "may",
     "`support_decay_error`, estimated (`supports.coupling: diagonal`)", may_be_nan},
    {"support_pitch_error_estimate", "float64", "", "cent", "may",
     "`support_pitch_error`, estimated (`supports.coupling: diagonal`)", may_be_nan},
    {"click_peak", "float64", "", "Pa", "struck:click",
     "largest magnitude of the acceleration click at any listener; 0 where none hears it"},
    {"click_left_out", "int64", "", "1", "struck:click",
     "listeners so near the object that they are without the click"},

    // Motion.
    {"simulation", "int64", "", "1", "motion", "number of the simulation"},
    {"bodies", "text", "", "1", "motion",
     "JSON: `name`, `fixed`, `shape`, `material`, `size` and `mass_kg` of each body, in the order "
     "of "
     "the numbers used below; the ground is the first, a stylus the last"},
    {"poses", "float64", "times,bodies,7", "m; w, x, y, z", "motion",
     "where the mesh's coordinates (those of `modes/`, times `size`) lie in the world: origin, and "
     "rotation as a unit quaternion; every `pose_step` seconds from 0"},
    {"pose_step", "float64", "", "s", "motion", "time between two poses"},
    {"energy", "float64", "times", "J", "motion", "kinetic, and of height, of all that moves"},
    {"left", "float64", "bodies", "s", "motion", "when it left the world; NaN: never", may_be_nan},
    {"start_overlap", "float64", "", "m", "motion",
     "by which bodies are in one another at the start, at the most; 0 up to a thousandth of the "
     "smaller one's reach"},
    {"substeps", "int64", "", "1", "motion", "most parts of a step"},
    {"too_fast_at", "float64", "", "s", "motion",
     "when a body was first too fast for 64 parts of a step; NaN: never", may_be_nan},
    {"strikes", "int64", "", "1", "motion",
     "how many there were; those stored are in order of time, unused rows NaN (bodies: -1)"},
    {"strike_time", "float64", "kept", "s", "motion", "when", may_be_nan},
    {"strike_bodies", "int64", "kept,2", "1", "motion", "numbers of both bodies"},
    {"strike_point", "float64", "kept,3", "m", "motion", "where, in the world", may_be_nan},
    {"strike_normal", "float64", "kept,3", "1", "motion", "points into the first body", may_be_nan},
    {"strike_impulse", "float64", "kept,3", "N s", "motion", "acts on the first body", may_be_nan},
    {"strike_speed", "float64", "kept", "m/s", "motion",
     "approach along the normal (of a shock through what rests already: the impulse over the "
     "pair's "
     "mass)",
     may_be_nan},
    {"strike_duration", "float64", "kept", "s", "motion", "Hertz's contact time", may_be_nan},
    {"lasting_contacts", "int64", "", "1", "motion", "how many there were"},
    {"touch", "float64", "ticks,3", "N", "touch",
     "force of the face on the stylus' tip, world, every 1 / `touch_rate` seconds"},
    {"touch_tip", "float64", "ticks,3", "m", "touch", "where the tip is"},
    {"touch_hand", "float64", "ticks,3", "m", "touch", "where the hand is"},
    {"touch_rate", "float64", "", "Hz", "touch", "of the ticks"},
    {"touch_limited", "int64", "", "1", "touch", "ticks whose force was shortened"},
    {"touch_held_back", "int64", "", "1", "touch",
     "ticks in which the face pushed less than its spring would, so as not to feed energy"},
    {"frames", "uint8", "frames,height,width,3", "sRGB", "movie",
     "pictures of `motion.camera`, `frame_rate` a second from 0"},
    {"depth", "float32", "frames,height,width", "m", "may",
     "along the camera's axis; 0: nothing there (`motion.camera.depth_maps`)"},
    {"masks", "uint8", "frames,height,width", "1", "may",
     "0: background or ground; else a body's number among `bodies` without the ground, plus 1 "
     "(`motion.camera.masks`)"},
    {"frame_rate", "float64", "", "Hz", "movie", "of the frames"},

    // Rooms and recording.
    {"room", "int64", "", "1", "room|tail", "number of the room, the same for all samples in it"},
    {"room_size", "float64", "3", "m", "room|tail", "sides of the room"},
    {"room_source", "float64", "3", "m", "room|tail", "where the object's centre stands in it"},
    {"room_rt60", "float64", "8", "s", "room|tail",
     "reverberation time by Eyring's formula, octaves from 125 Hz to 16 kHz"},
    {"room_listener", "float64", "3", "m", "may",
     "where the listener is in it (`room.input: dry`)"},
    {"tail_level", "float64", "listeners", "dB", "tail",
     "energy of the tail against the direct sound, in the loudest octave"},
    {"tail_join", "float64", "listeners", "dB", "tail",
     "how far the images before the join are beyond the 6 dB by which the tail follows them; 0 "
     "within"},
    {"room_response", "text", "", "1", "response",
     "file of the measured response, within `room.responses`"},
    {"room_response_channel", "int64", "", "1", "response", "its channel in the file, from 1"},
    {"noise_ratio", "float64", "", "dB", "noise",
     "signal-to-noise ratio over the active part; NaN where the clip is silent", may_be_nan},
    {"noise_level", "float64", "", "m/s|Pa", "noise",
     "root mean square of the noise over the active part, before `gain`"},
    {"noise_source", "text", "", "1", "noise",
     "its kind, or the stretches of recordings: `name start+duration; ...`"},
    {"active_begin", "float64", "", "s", "noise",
     "where the sound begins in the clip; negative: in the tail of an earlier strike"},
    {"active_end", "float64", "", "s", "noise", "where it ends"},
    {"recording_shift", "float64", "", "s", "may",
     "how much later the sound comes (`recording.shift`)"},
    {"recording_low_cut", "float64", "", "Hz", "may", "lower limit (`recording.low_cut`)"},
    {"recording_high_cut", "float64", "", "Hz", "may", "upper limit (`recording.high_cut`)"},
    {"recording_gain", "float64", "", "dB", "recording", "on top of `gain`"},
    {"recording_clipped", "int64", "", "1", "recording",
     "samples held at `clip` or at the converter's full scale"},
    {"recording_bits", "int64", "", "1", "recording", "bits of a sample; 0: not rounded"},
    {"recording_codec", "text", "", "1", "may", "what kept the clip (`recording.codec`)"},
    {"recording_compression", "float64", "", "1", "may", "of `recording_codec`; NaN of `none`",
     may_be_nan},
    {"recording_length", "float64", "", "s", "may",
     "when the clip stops after the sound began (`recording.length`)"},
    {"recording_silent", "int64", "", "1", "recording", "1: nothing but zeros is stored"},
};

}  // namespace

std::span<const core::ColumnRule> columns() {
  return list;
}

}  // namespace carillon::scene
