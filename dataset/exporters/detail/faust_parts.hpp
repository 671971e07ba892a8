#pragma once

namespace carillon::dataset::exporters {

/// What every Faust program of an object says after its settings and tables: the strike, and the
/// modes as resonators.
///
/// A mode's state is (omega q, q'). One sample multiplies it by the exact solution over a step: a
/// matrix whose norm is at most 1, as the energy of a damped oscillator never grows. So the bank is
/// stable for every setting, below, at and above critical damping, and while settings move.
///
/// The force of a strike, (1 - cos(2 pi t / T)) / T, is no sampled signal: its effect on the state
/// over each step is an integral in closed form. Of x' = A x + e exp(i w t) with the particular
/// solution X exp(i w t), X = (i w - A)^-1 e, it is J(h) exp(i w t) with J(h) = X exp(i w h) -
/// exp(A h) X. The contact's end within a step is made by the same force, begun anew at its end and
/// taken away, as the force has the contact's own period.
///
/// Faust has no loops: what is written for each mode is compiled for each, and the solution over a
/// step is long. So it is written once, computed for one mode in each sample, and kept in tables,
/// and a resonator only reads them. Everything that is struck waits for a round through the modes,
/// after which the tables hold what was set when the gate opened.
inline constexpr const char* faust_parts = R"(
// ---- Time and the strike

step = 1/ma.SR;
turn = 2*ma.PI/contactTime;              // of the contact [rad/s]
lastStep = int(contactTime*ma.SR);       // that the contact reaches into
rest = (lastStep + 1)*step - contactTime;  // what is left of it after the contact [s]

// The force of a strike begun by a trigger, a raised cosine (1 - cos(turn t))/contactTime: its
// constant part, that part times cosine and sine at the begin of each step, and the step it ends in.
contact(trigger, impulse) = force, force*cos(turn*time), force*sin(turn*time), force*(since == lastStep)
with {
  count = (+(1) : min(1<<24)) ~ *(1 - trigger);  // 1 in the sample of the trigger
  since = count - 2;                             // steps begun before the one that ends here
  struck = max(trigger) ~ _;
  touches = struck*(since >= 0)*(since <= lastStep);
  time = touches*since*step;
  force = touches*impulse/contactTime;
};

// ---- A mode, q'' + 2 d q' + lambda q = force, over a step: the matrix of its state (w q, q'), and
// what a force of 1, cos(turn t), sin(turn t), the contact's end and an impulse add to the state.

least = max(ma.EPSILON*ma.SR, 1e-6);  // decay rate [1/s] that no rounding outweighs

solution(eigenvalue, gain) = aa(step), ab(step), bb(step),
  g*one1(step), g*one2(step), g*(0 - cos1(step)), g*(0 - cos2(step)), g*sin1(step), g*sin2(step),
  g*(cos1(rest) - one1(rest)), g*(cos2(rest) - one2(rest)), g*step
with {
  lambda = eigenvalue*pitch*pitch;
  w = sqrt(lambda);
  d = max(least, rateAt(lambda)/t60_factor);
  square = (w - d)*(w + d);                     // of the damped angular frequency
  heard = square < (ma.PI*ma.SR)*(ma.PI*ma.SR);  // below half the sample rate
  g = heard*gain/(size*size*size);              // the object's mass grows with its volume

  // It oscillates, or is overdamped. Within `near` of critical it is taken for oscillating: a small
  // x = -square t^2 > 0, where sin and cos would be sinh and cosh, then adds to both.
  near = 1e-6*ma.SR*ma.SR;
  overdamped = square < 0 - near;
  root = sqrt(max(1e-6*near, abs(square)));
  x(t) = max(0, 0 - square)*t*t;
  fall(t) = heard*exp(0 - select2(overdamped, d, lambda/(d + root))*t);
  lost(t) = exp(0 - 2*root*t);  // of the faster of two exponentials against the slower
  even(t) = fall(t)*select2(overdamped, cos(root*t)*(1 + x(t)), (1 + lost(t))/2);
  slope(t) = fall(t)*select2(overdamped, sin(root*t)*(1 + x(t)/3), (1 - lost(t))/2)/root;
  aa(t) = even(t) + d*slope(t);
  ab(t) = w*slope(t);
  bb(t) = even(t) - d*slope(t);

  detuned = lambda - turn*turn;
  damped = 2*d*turn;
  size2 = detuned*detuned + damped*damped;
  ar = w*detuned/size2;
  ai = 0 - w*damped/size2;
  br = turn*damped/size2;
  bi = turn*detuned/size2;
  c(t) = cos(turn*t);
  s(t) = sin(turn*t);
  one1(t) = (1 - aa(t))/w;
  one2(t) = slope(t);
  cos1(t) = ar*c(t) - ai*s(t) - aa(t)*ar - ab(t)*br;
  cos2(t) = br*c(t) - bi*s(t) + ab(t)*ar - bb(t)*br;
  sin1(t) = ar*s(t) + ai*c(t) - aa(t)*ai - ab(t)*bi;
  sin2(t) = br*s(t) + bi*c(t) + ab(t)*ai - bb(t)*bi;
};

// ---- The object: every mode reads what was computed of it last.

bank(vertex) = _, _, _, _, _ <: par(i, modes, (i, _, _, _, _, _ : resonator)) :> _
with {
  resonator(i, force, cosine, sine, end, impulse) = v letrec {
    'x = at(0)*x + at(1)*v + at(3)*force + at(5)*cosine + at(7)*sine + at(9)*end;
    'v = at(2)*v - at(1)*x + at(4)*force + at(6)*cosine + at(8)*sine + at(10)*end + at(11)*impulse;
  } with {
    at(k) = rwtable(modes, 0.0, next, (solution(eigenvalue, gainAt(vertex)) : ba.selector(k, 12)), i);
  };
};

object(vertex, force) = 0, 0, 0, 0, force@modes : bank(vertex);
process(force) = (contact(struck@modes, impulse : ba.sAndH(struck) : @(modes)), force@modes : bank(vertex))*level
with {
  struck = gate > gate';
};
)";

}  // namespace carillon::dataset::exporters
