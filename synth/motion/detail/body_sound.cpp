#include "synth/motion/detail/body_sound.hpp"

#include <algorithm>
#include <cmath>

#include "synth/contact/hertz_pulse.hpp"
#include "synth/motion/detail/slow_rates.hpp"

namespace carillon::synth::motion {

namespace {

/// Mode shapes along a contact's way are taken every so much of the body's size.
constexpr double place_fraction = 0.005;

double size_of(const solvers::modes::ModeSurface& surface) {
  Vec3 low = surface.nodes.front(), high = low;
  for (const Vec3& node : surface.nodes) {
    low = low.cwiseMin(node);
    high = high.cwiseMax(node);
  }
  return (high - low).norm();
}

}  // namespace

bool sounds(const SoundingBody& body) {
  return body.modes != nullptr && body.modes->size() > 0;
}

modal::ContactForce pulse_of(const Impact& impact, const MotionSoundOptions& options) {
  return options.hertz_pulses ? contact::hertz_pulse(impact.duration)
                              : modal::ContactForce{impact.duration};
}

BodySound::BodySound(const Motion& motion, std::size_t body, const SoundingBody& sounding,
                     std::span<const modal::Listener> listeners, const MotionSoundOptions& options,
                     ContactForces& forces, MotionSound& report)
    : motion_(motion),
      body_(body),
      sounding_(sounding),
      options_(options),
      forces_(forces),
      report_(report),
      sampler_(sounding.modes->surface),
      modes_(sounding.modes->eigenvalues, sounding.decay_rates, options.sample_rate),
      gains_(motion, body, sounding, listeners, options.turn, options.moving_radiation),
      heard_(!listeners.empty()) {
  for (const Impact& impact : motion.impacts) {
    if (options.impacts && (impact.bodies[0] == body || impact.bodies[1] == body)) {
      impacts_.push_back(&impact);
    }
  }
  damps_ = options.contact_damping && sounding.rests.coefficient > 0;
  for (const HoldingString& string : sounding.strings) {
    if (!options.contact_damping) break;
    held_.push_back(modal::shapes_at(*sounding.modes, sampler_.nearest(string.at)));
  }
  const double spacing = place_fraction * size_of(sounding.modes->surface);
  for (std::size_t number = 0; number < motion.contacts.size(); ++number) {
    const LastingContact& contact = motion.contacts[number];
    for (std::size_t side = 0; (damps_ || options.lasting_contacts) && side < 2; ++side) {
      if (contact.bodies[side] != body || contact.steps.empty()) continue;
      const Stopwatch watch(damps_ ? report.contact_damping : report.lasting_contacts);
      contacts_.push_back({&contact, number, side,
                           ContactPlaces(*sounding.modes, sampler_, contact, side, spacing)});
    }
  }
}

BodySound::~BodySound() {
  for (const TouchingContact& contact : contacts_) forces_.leave(contact.number, body_);
}

Eigen::MatrixXd BodySound::emitted(Eigen::Index count, Eigen::Index rows) {
  Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(count, rows);
  const double length = motion_.step * options_.sample_rate;
  const auto begin_of = [&](std::size_t step) {
    return std::min(count,
                    static_cast<Eigen::Index>(std::ceil(static_cast<double>(step) * length)));
  };
  for (std::size_t step = 0; begin_of(step) < count; ++step) {
    const Eigen::Index begin = begin_of(step), size = begin_of(step + 1) - begin;
    if (size == 0) continue;
    follow(step);
    strike(static_cast<double>(begin) / options_.sample_rate,
           static_cast<double>(begin + size) / options_.sample_rate);
    const std::vector<Drive> driven = drives(step, begin, size);
    if (modes_.resting() && driven.empty()) {
      modes_.skip(static_cast<std::size_t>(size));
      continue;
    }
    damp(step);
    DrivenGains gains;
    {
      const Stopwatch watch(report_.moving_radiation);
      gains = gains_.over(step);
    }
    const Stopwatch watch(report_.ringing);
    ++report_.ringing.calls;
    modes_.render(driven, gains, samples.middleRows(begin, size));
  }
  report_.mode_samples += modes_.mode_samples();
  report_.moving_radiation.calls += gains_.poses();
  return samples;
}

/// Contacts that act in a step; steps come one after the other.
void BodySound::follow(std::size_t step) {
  std::erase_if(acting_, [&](TouchingContact* contact) {
    if (step < contact->end_step()) return false;
    contact->slow_rates = {};
    return true;
  });
  for (; begun_ < contacts_.size() && contacts_[begun_].contact->first_step <= step; ++begun_) {
    if (step < contacts_[begun_].end_step()) acting_.push_back(&contacts_[begun_]);
  }
}

/// What drives the body from step to step, where anything does.
std::vector<Drive> BodySound::drives(std::size_t step, Eigen::Index begin, Eigen::Index size) {
  std::vector<Drive> result;
  if (!options_.lasting_contacts) return result;
  const Stopwatch watch(report_.lasting_contacts);
  for (TouchingContact* acting : acting_) {
    TouchingContact& contact = *acting;
    const LastingForce& force = forces_.force(contact.number);
    const Eigen::Index from = begin - static_cast<Eigen::Index>(force.first_sample);
    const Eigen::Index known = std::min<Eigen::Index>(size + 1, force.force.cols() - from);
    if (from < 0 || known <= 0 || force.force.middleCols(from, known).isZero(0)) continue;
    const std::size_t at = step - contact.contact->first_step;
    Drive& drive = result.emplace_back();
    drive.begin = contact.places.shapes(at);
    drive.end = contact.places.shapes(at + 1);
    drive.forces = Eigen::Matrix3Xd::Zero(3, size + 1);
    // From the world to the body, which turns meanwhile.
    const std::size_t last = motion_.states.size() - 1;
    const auto to_body = [&](std::size_t state) -> Eigen::Matrix3d {
      const Pose& pose = motion_.states[std::min(state, last)][body_].pose;
      return (contact.side == 0 ? 1 : -1) * pose.turn.conjugate().toRotationMatrix();
    };
    const Eigen::Matrix3d turn = to_body(step), turned = to_body(step + 1) - turn;
    if (heard_ && contact.slow_rates.empty()) {
      contact.slow_rates = slow_rates(force.force, options_.sample_rate, modes_.octaves());
    }
    drive.slow_rates.resize(contact.slow_rates.size());
    for (Eigen::Index n = 0; n < known; ++n) {
      const double fraction = static_cast<double>(n) / static_cast<double>(size);
      drive.forces.col(n) = (turn + fraction * turned) * force.force.col(from + n);
    }
    const Eigen::Matrix3f turn_rates = turn.cast<float>();
    for (std::size_t octave = 0; octave < contact.slow_rates.size(); ++octave) {
      const Eigen::Matrix3Xf& rates = contact.slow_rates[octave];
      if (rates.cols() == 0) continue;
      const Eigen::Index rest = std::min(size, known);
      drive.slow_rates[octave] = Eigen::Matrix3Xf::Zero(3, size);
      drive.slow_rates[octave].leftCols(rest) = turn_rates * rates.middleCols(from, rest);
    }
    ++report_.lasting_contacts.calls;
  }
  return result;
}

void BodySound::strike(double from, double to) {
  const Stopwatch watch(report_.impacts);
  for (; struck_ < impacts_.size() && impacts_[struck_]->time < to; ++struck_) {
    const Impact& impact = *impacts_[struck_];
    for (std::size_t side = 0; side < 2; ++side) {
      if (impact.bodies[side] != body_) continue;
      const Vec3 impulse = (side == 0 ? 1.0 : -1.0) * impact.impulse;
      const Vec3 own = pose_at(motion_, body_, impact.time).turn.conjugate() * impulse;
      const Eigen::MatrixX3d shapes =
          modal::shapes_at(*sounding_.modes, sampler_.nearest(impact.points[side]));
      modes_.strike(shapes * own, pulse_of(impact, options_), std::max(0.0, impact.time - from));
      ++report_.impacts.calls;
    }
  }
}

void BodySound::damp(std::size_t step) {
  if (!damps_ && held_.empty()) return;
  const Stopwatch watch(report_.contact_damping);
  bool rests = false;
  std::vector<double> rates = sounding_.decay_rates;
  for (std::size_t s = 0; s < held_.size(); ++s) {
    const HoldingString& string = sounding_.strings[s];
    if (step >= motion_.tensions.size()) break;
    const double tension = motion_.tensions[step][string.number];
    if (!(tension > 0)) continue;
    const Vec3 along = motion_.states[step][body_].pose.to_body(string.anchor) - string.at;
    if (!(along.norm() > 0)) continue;
    support::add_support_damping(rates,
                                 unit_damping(held_[s], along.normalized(), string.kind.friction),
                                 string.kind.coefficient, tension);
    rests = true;
    ++report_.contact_damping.calls;
  }
  for (const TouchingContact* acting : acting_) {
    if (!damps_) break;
    const TouchingContact& contact = *acting;
    const std::size_t at = step - contact.contact->first_step;
    const Vec3 normal =
        motion_.states[step][body_].pose.turn.conjugate() * contact.contact->steps[at].normal;
    support::add_support_damping(
        rates, unit_damping(contact.places.shapes(at), normal, sounding_.rests.friction),
        sounding_.rests.coefficient, forces_.normal_force(contact.number)[at]);
    rests = true;
    ++report_.contact_damping.calls;
  }
  if (rests || rested_) modes_.set_decay_rates(rates);
  rested_ = rests;
}

}  // namespace carillon::synth::motion
