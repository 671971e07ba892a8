#pragma once

namespace carillon::dataset::exporters {

/// What every Faust program of an object says before its modes: the strike, and a mode as a
/// resonator.
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
inline constexpr const char* faust_parts = R"(
// ---- Time and the strike

step = 1/ma.SR;
turn = 2*ma.PI/contactTime;              // of the contact [rad/s]
lastStep = int(contactTime*ma.SR);       // that the contact reaches into
rest = (lastStep + 1)*step - contactTime;  // what is left of it after the contact [s]

// The force of a strike begun by a trigger, a raised cosine (1 - cos(turn t))/contactTime: its
// constant part, that part times cosine and sine at the begin of each step, and the step it ends in.
contact(trigger, impulse) = level, level*cos(turn*time), level*sin(turn*time), level*(since == lastStep)
with {
  count = (+(1) : min(1<<24)) ~ *(1 - trigger);  // 1 in the sample of the trigger
  since = count - 2;                             // steps begun before the one that ends here
  struck = max(trigger) ~ _;
  touches = struck*(since >= 0)*(since <= lastStep);
  time = touches*since*step;
  level = touches*ba.sAndH(trigger, impulse)/contactTime;
};

// ---- A mode: q'' + 2 d q' + lambda q = force

least = max(ma.EPSILON*ma.SR, 1e-6);  // decay rate [1/s] that no rounding outweighs

mode(eigenvalue, rate, gain, level, cosine, sine, end, force) = ring
with {
  lambda = eigenvalue/(size*size);
  w = sqrt(lambda);
  d = max(least, rate(lambda));
  square = (w - d)*(w + d);  // of the damped angular frequency
  near = 1e-6*ma.SR*ma.SR;
  root = sqrt(max(near, abs(square)));
  fast = d + root;
  slow = lambda/fast;
  // It oscillates, is overdamped, or is so near to critical that a series serves.
  kind(a, b, c) = select2(square > near, select2(square < 0 - near, c, b), a);
  slope(t) = kind(exp(0 - d*t)*sin(root*t)/root, (exp(0 - slow*t) - exp(0 - fast*t))/(2*root),
                  t*exp(0 - d*t)*(1 - x/6 + x*x/120)) with { x = square*t*t; };
  even(t) = kind(exp(0 - d*t)*cos(root*t), (exp(0 - slow*t) + exp(0 - fast*t))/2,
                 exp(0 - d*t)*(1 - x/2 + x*x/24)) with { x = square*t*t; };
  // The state (w q, q') after a time t.
  aa(t) = even(t) + d*slope(t);
  ab(t) = w*slope(t);
  bb(t) = even(t) - d*slope(t);

  // What a force of 1, cos(turn t) and sin(turn t) has done to the state after a time t.
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

  heard = square < (ma.PI*ma.SR)*(ma.PI*ma.SR);  // below half the sample rate
  g = heard*gain/(size*size*size);               // the object's mass grows with its volume
  in1 = (g*one1(step))*level - (g*cos1(step))*cosine + (g*sin1(step))*sine
      - (g*(one1(rest) - cos1(rest)))*end;
  in2 = (g*one2(step))*level - (g*cos2(step))*cosine + (g*sin2(step))*sine
      - (g*(one2(rest) - cos2(rest)))*end + (g*step)*force;
  ring = v letrec {
    'x = (heard*aa(step))*x + (heard*ab(step))*v + in1;
    'v = (heard*bb(step))*v - (heard*ab(step))*x + in2;
  };
};
)";

}  // namespace carillon::dataset::exporters
