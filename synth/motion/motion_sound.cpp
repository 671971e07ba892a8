#include "synth/motion/motion_sound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "synth/hertz_pulse.hpp"
#include "synth/motion/check_motion.hpp"
#include "synth/motion/contact_places.hpp"
#include "synth/motion/flight_delay.hpp"
#include "synth/motion/moving_gains.hpp"
#include "synth/motion/slow_rates.hpp"

namespace carillon::synth {

namespace {

/// A click is over so many times the sphere's radius over the speed of sound after the force.
constexpr double kClickEnd = 30;
/// Mode shapes along a contact's way are taken every so much of the body's size.
constexpr double kPlaceShare = 0.005;

/// Adds the time since its making to a part's seconds.
class Stopwatch {
 public:
  explicit Stopwatch(EffectUse& use) : use_(use), begin_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    use_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  EffectUse& use_;
  std::chrono::steady_clock::time_point begin_;
};

double size_of(const solvers::ModeSurface& surface) {
  Vec3 low = surface.nodes.front(), high = low;
  for (const Vec3& node : surface.nodes) {
    low = low.cwiseMin(node);
    high = high.cwiseMax(node);
  }
  return (high - low).norm();
}

bool sounds(const SoundingBody& body) {
  return body.modes != nullptr && body.modes->size() > 0;
}

/// Forces of the lasting contacts, each computed once for both of its bodies.
class ContactForces {
 public:
  ContactForces(const Motion& motion, std::span<const MovingBody> moving,
                std::span<const SoundingBody> bodies, const MotionSoundOptions& options)
      : forces_(motion, moving, with_rate(options)), found_(motion.contacts.size()) {
    for (const LastingContact& contact : motion.contacts) {
      std::size_t& last = last_.emplace_back(0);
      for (const std::size_t body : contact.bodies) {
        if (sounds(bodies[body])) last = std::max(last, body);
      }
    }
  }

  const std::vector<double>& normal_force(std::size_t contact) const {
    return forces_.normal_force(contact);
  }
  const LastingForce& force(std::size_t contact) {
    if (!found_[contact]) found_[contact] = forces_.force(contact);
    return *found_[contact];
  }
  /// A body has no more use of the contact's force: the last that sounds has it dropped.
  void leave(std::size_t contact, std::size_t body) {
    if (last_[contact] == body) found_[contact].reset();
  }

 private:
  static LastingForceOptions with_rate(const MotionSoundOptions& options) {
    LastingForceOptions contacts = options.contacts;
    contacts.sample_rate = options.sample_rate;
    return contacts;
  }
  LastingForces forces_;
  std::vector<std::optional<LastingForce>> found_;
  std::vector<std::size_t> last_;  ///< of each contact's bodies that sounds
};

/// A lasting contact as one of its bodies has it.
struct TouchingContact {
  const LastingContact* contact;
  std::size_t number;
  std::size_t side;
  ContactPlaces places;
  /// Of its force, while it lasts; where there are listeners.
  std::vector<Eigen::Matrix3Xf> slow_rates = {};

  std::size_t end_step() const { return contact->first_step + contact->steps.size(); }
};

/// One body's way through the motion.
class BodySound {
 public:
  BodySound(const Motion& motion, std::size_t body, const SoundingBody& sounding,
            std::span<const Listener> listeners, const MotionSoundOptions& options,
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
    const double spacing = kPlaceShare * size_of(sounding.modes->surface);
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

  ~BodySound() {
    for (const TouchingContact& contact : contacts_) forces_.leave(contact.number, body_);
  }
  BodySound(const BodySound&) = delete;
  BodySound& operator=(const BodySound&) = delete;

  /// Rows as they leave the body, samples x rows.
  Eigen::MatrixXd emitted(Eigen::Index count, Eigen::Index rows) {
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

  const MovingGains& gains() const { return gains_; }

 private:
  /// Contacts that act in a step; steps come one after the other.
  void follow(std::size_t step) {
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
  std::vector<Drive> drives(std::size_t step, Eigen::Index begin, Eigen::Index size) {
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
        const double share = static_cast<double>(n) / static_cast<double>(size);
        drive.forces.col(n) = (turn + share * turned) * force.force.col(from + n);
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

  void strike(double from, double to) {
    const Stopwatch watch(report_.impacts);
    for (; struck_ < impacts_.size() && impacts_[struck_]->time < to; ++struck_) {
      const Impact& impact = *impacts_[struck_];
      for (std::size_t side = 0; side < 2; ++side) {
        if (impact.bodies[side] != body_) continue;
        const Vec3 impulse = (side == 0 ? 1.0 : -1.0) * impact.impulse;
        const Vec3 own = pose_at(motion_, body_, impact.time).turn.conjugate() * impulse;
        const Eigen::MatrixX3d shapes =
            shapes_at(*sounding_.modes, sampler_.nearest(impact.points[side]));
        modes_.strike(shapes * own, pulse_of(impact, options_), std::max(0.0, impact.time - from));
        ++report_.impacts.calls;
      }
    }
  }

  void damp(std::size_t step) {
    if (!damps_) return;
    const Stopwatch watch(report_.contact_damping);
    bool rests = false;
    std::vector<double> rates = sounding_.decay_rates;
    for (const TouchingContact* acting : acting_) {
      const TouchingContact& contact = *acting;
      const std::size_t at = step - contact.contact->first_step;
      const Vec3 normal =
          motion_.states[step][body_].pose.turn.conjugate() * contact.contact->steps[at].normal;
      add_support_damping(rates,
                          unit_damping(contact.places.shapes(at), normal, sounding_.rests.friction),
                          sounding_.rests.coefficient, forces_.normal_force(contact.number)[at]);
      rests = true;
      ++report_.contact_damping.calls;
    }
    if (rests || rested_) modes_.set_decay_rates(rates);
    rested_ = rests;
  }

 public:
  static ContactForce pulse_of(const Impact& impact, const MotionSoundOptions& options) {
    return options.hertz_pulses ? hertz_pulse(impact.duration) : ContactForce{impact.duration};
  }

 private:
  const Motion& motion_;
  std::size_t body_;
  const SoundingBody& sounding_;
  const MotionSoundOptions& options_;
  ContactForces& forces_;
  MotionSound& report_;
  SurfaceSampler sampler_;
  DrivenModes modes_;
  MovingGains gains_;
  std::vector<const Impact*> impacts_;
  std::size_t struck_ = 0;
  std::vector<TouchingContact> contacts_;  ///< in order of their begin
  std::vector<TouchingContact*> acting_;   ///< those of the present step
  std::size_t begun_ = 0;
  bool heard_;  ///< by listeners, as pressure
  bool damps_ = false;
  bool rested_ = false;
};

/// Clicks of both bodies of every impact, straight into the listeners' rows.
void add_clicks(const Motion& motion, std::span<const SoundingBody> bodies,
                std::span<const Listener> listeners, const MotionSoundOptions& options,
                Eigen::MatrixXd& heard, MotionSound& report) {
  const Stopwatch watch(report.clicks);
  for (const Impact& impact : motion.impacts) {
    const ContactForce force = BodySound::pulse_of(impact, options);
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t body = impact.bodies[side];
      if (!bodies[body].click) continue;
      const RigidSource& source = *bodies[body].click;
      const Pose pose = pose_at(motion, body, options.moving_radiation ? impact.time : 0);
      const Vec3 impulse = (side == 0 ? 1.0 : -1.0) * impact.impulse;
      const double first = std::floor(impact.time * options.sample_rate);
      for (std::size_t row = 0; row < listeners.size(); ++row) {
        const Vec3 place = pose.to_body(listeners[row].position);
        const double lasts = (place - source.centre).norm() / kSoundSpeed + impact.duration +
                             kClickEnd * source.radii.maxCoeff() / kSoundSpeed;
        const double end = std::min(static_cast<double>(heard.rows()),
                                    first + std::ceil(lasts * options.sample_rate) + 2);
        if (!(first < end)) continue;
        const std::vector<float> click =
            acceleration_click(source, pose.turn.conjugate() * impulse, force, place,
                               options.sample_rate, static_cast<std::size_t>(end - first),
                               std::max(0.0, impact.time - first / options.sample_rate));
        for (std::size_t n = 0; n < click.size(); ++n) {
          heard(static_cast<Eigen::Index>(first) + static_cast<Eigen::Index>(n),
                static_cast<Eigen::Index>(row)) += static_cast<double>(click[n]);
        }
        ++report.clicks.calls;
      }
    }
  }
}

void check(const Motion& motion, std::span<const MovingBody> moving,
           std::span<const SoundingBody> bodies, const MotionSoundOptions& options) {
  if (motion.states.empty() || !(motion.step > 0)) {
    throw core::InputError("moving sound: a motion without states");
  }
  if (motion.states.front().size() != bodies.size() || moving.size() != bodies.size()) {
    throw core::InputError(fmt::format("moving sound: {} bodies sound where {} move", bodies.size(),
                                       motion.states.front().size()));
  }
  if (!(options.sample_rate > 0) || !std::isfinite(options.sample_rate) ||
      !(options.seconds >= 0) || !std::isfinite(options.seconds)) {
    throw core::InputError(
        fmt::format("moving sound: {} s at {} Hz", options.seconds, options.sample_rate));
  }
  check_finite(motion);
  if (!(options.turn > 0)) {
    throw core::InputError(
        fmt::format("moving sound: poses must be some angle apart, not {} rad", options.turn));
  }
}

}  // namespace

MotionSound motion_sound(const Motion& motion, std::span<const MovingBody> moving,
                         std::span<const SoundingBody> bodies, std::span<const Listener> listeners,
                         const MotionSoundOptions& options) {
  check(motion, moving, bodies, options);
  const double seconds = options.seconds > 0
                             ? options.seconds
                             : static_cast<double>(motion.states.size() - 1) * motion.step;
  const auto count = static_cast<Eigen::Index>(std::llround(seconds * options.sample_rate));
  MotionSound sound;
  sound.rows = std::max<std::size_t>(1, listeners.size());
  sound.unit = listeners.empty() ? "m/s" : "Pa";
  const auto rows = static_cast<Eigen::Index>(sound.rows);
  ContactForces forces(motion, moving, bodies, options);
  Eigen::MatrixXd heard = Eigen::MatrixXd::Zero(count, rows);
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (!sounds(bodies[body])) continue;
    BodySound own(motion, body, bodies[body], listeners, options, forces, sound);
    const Eigen::MatrixXd samples = own.emitted(count, rows);
    if (options.limit.passed()) options.limit.refuse();
    for (Eigen::Index row = 0; row < rows; ++row) {
      if (samples.col(row).isZero(0)) continue;
      const std::vector<double> flights = own.gains().flight_times(static_cast<std::size_t>(row));
      const Stopwatch watch(sound.moving_radiation);
      add_arriving(samples.col(row), {motion.step, flights}, options.sample_rate, heard.col(row));
    }
  }
  if (options.clicks && !listeners.empty()) {
    add_clicks(motion, bodies, listeners, options, heard, sound);
  }
  sound.samples.resize(static_cast<std::size_t>(heard.size()));
  for (std::size_t n = 0; n < sound.samples.size(); ++n) {
    sound.samples[n] = static_cast<float>(heard.data()[n]);
  }
  return sound;
}

}  // namespace carillon::synth
