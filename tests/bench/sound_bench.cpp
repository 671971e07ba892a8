// One route of the sound benchmark, once: scripts/bench_sound runs the routes in turns and prints
// the table of docs/sound/speed.md. Prints one JSON object.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <ctime>
#include <functional>
#include <map>
#include <numbers>

#include "synth/modal/streaming_renderer.hpp"
#include "tests/synth/partial_sum.hpp"

namespace carillon::bench {
namespace {

using synth::modal::Partial;
constexpr double audio_rate = 44100;

/// Modes evenly spread in the logarithm from 60 Hz to 18 kHz.
/// @param damping  1: c = 6 + 1e-7 lambda, ceramic's; 0: none, so that no mode ever ends
synth::modal::RingDown modes_of(std::size_t modes, double damping) {
  synth::modal::RingDown rings;
  const auto n = static_cast<Eigen::Index>(modes);
  rings.excitation = Eigen::VectorXd::Ones(n);
  rings.readout.velocity.resize(1, n);
  rings.readout.delays = {0};
  for (std::size_t i = 0; i < modes; ++i) {
    const double fraction = (static_cast<double>(i) + 0.5) / static_cast<double>(modes);
    const double omega = 2 * std::numbers::pi * 60 * std::pow(300.0, fraction);
    rings.eigenvalues.push_back(omega * omega);
    rings.decay_rates.push_back(damping * (6 + 1e-7 * omega * omega) / 2);
    rings.readout.velocity(0, static_cast<Eigen::Index>(i)) = std::cos(static_cast<double>(i * i));
  }
  return rings;
}

std::vector<Partial> partials_of(const synth::modal::RingDown& rings) {
  std::vector<Partial> partials;
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const double d = rings.decay_rates[i];
    partials.push_back({rings.readout.velocity(0, static_cast<Eigen::Index>(i)), d,
                        std::sqrt(static_cast<long double>(rings.eigenvalues[i]) - d * d)});
  }
  return partials;
}

/// Processor time of this process [s]: other programs do not count.
double now() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Seconds of one call, from as many as take about 0.2 s.
double seconds_of(const std::function<void()>& work) {
  work();
  const double begin = now();
  int calls = 0;
  while (now() - begin < 0.2) {
    work();
    ++calls;
  }
  return (now() - begin) / calls;
}

using Sum = std::function<void(const std::vector<Partial>&, std::vector<double>&)>;

void kernel(const std::vector<Partial>& partials, std::vector<double>& out) {
  synth::add_partials(partials, 0, audio_rate, 0, 0, out);
}

void phasors(const std::vector<Partial>& partials, std::vector<double>& out) {
  for (const Partial& p : partials) {
    const auto omega = static_cast<double>(p.angular_frequency);
    const std::complex<double> step =
        std::exp(std::complex<double>(-p.decay_rate, omega) / audio_rate);
    double re = p.amplitude.real();
    double im = p.amplitude.imag();
    for (double& sample : out) {
      sample += re;
      const double next = re * step.real() - im * step.imag();
      im = re * step.imag() + im * step.real();
      re = next;
    }
  }
}

void exponentials(const std::vector<Partial>& partials, std::vector<double>& out) {
  for (const Partial& p : partials) {
    const auto omega = static_cast<double>(p.angular_frequency);
    for (std::size_t n = 0; n < out.size(); ++n) {
      const double t = static_cast<double>(n) / audio_rate;
      out[n] += p.amplitude.real() * std::exp(-p.decay_rate * t) * std::cos(omega * t);
    }
  }
}

/// Largest deviation from the sum in extended precision, relative to its peak [dB].
double deviation(const std::vector<Partial>& partials, const std::vector<double>& out) {
  double peak = 0;
  double worst = 0;
  for (std::size_t n = 0; n < out.size(); n += 7) {
    const long double t = static_cast<long double>(n) / audio_rate;
    long double sum = 0;
    for (const Partial& p : partials) {
      sum += p.amplitude.real() * std::exp(-p.decay_rate * t) * std::cos(p.angular_frequency * t);
    }
    peak = std::max(peak, static_cast<double>(std::abs(sum)));
    worst = std::max(worst, static_cast<double>(std::abs(sum - out[n])));
  }
  return 20 * std::log10(worst / peak);
}

void sums(const Sum& route, std::size_t modes, bool check) {
  const auto partials = partials_of(modes_of(modes, check ? 1 : 0.05));
  std::vector<double> out(static_cast<std::size_t>(audio_rate), 0.0);
  if (check) {
    route(partials, out);
    fmt::print("{{\"deviation_db\": {}}}\n", deviation(partials, out));
    return;
  }
  const double seconds = seconds_of([&] {
    std::fill(out.begin(), out.end(), 0.0);
    route(partials, out);
  });
  fmt::print("{{\"mode_samples_per_s\": {}}}\n", static_cast<double>(modes * out.size()) / seconds);
}

/// A whole sample of one second, from the modes to floats.
void samples(std::size_t modes, double contact_time, bool burst) {
  const synth::modal::RingDown rings = modes_of(modes, 1);
  synth::modal::ContactForce force{contact_time, {}};
  if (burst) {
    const auto points = static_cast<std::size_t>(std::lround(contact_time * audio_rate)) + 1;
    force.duration = static_cast<double>(points - 1) / audio_rate;
    for (std::size_t i = 0; i < points; ++i) {
      force.samples.push_back(std::cos(static_cast<double>(i * i)) / contact_time);
    }
  }
  float last = 0;
  const double seconds = seconds_of([&] {
    last += synth::modal::synthesize(rings, force, audio_rate,
                                     static_cast<std::size_t>(audio_rate))[1000];
  });
  fmt::print("{{\"seconds_per_sample\": {}, \"check\": {}}}\n", seconds, last);
}

/// Seconds of work for one second of `bodies` that all ring and never end.
double stream_seconds(std::size_t bodies, std::size_t modes, std::size_t block) {
  synth::modal::StreamingRenderer renderer(1, audio_rate);
  const synth::modal::RingDown rings = modes_of(modes, 0);
  for (std::size_t i = 0; i < bodies; ++i) {
    const std::size_t body = renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
    renderer.strike(body, rings.excitation, {1e-3}, 1e-6 * static_cast<double>(i));
  }
  std::vector<float> out(block);
  for (int i = 0; i < 20; ++i) renderer.render(out);
  const double begin = now();
  const auto blocks = static_cast<std::size_t>(audio_rate / 4) / block;
  for (std::size_t i = 0; i < blocks; ++i) renderer.render(out);
  return (now() - begin) * audio_rate / static_cast<double>(blocks * block);
}

/// How many bodies a second's work renders for a second, measured with about as many.
void stream(std::size_t modes, std::size_t block) {
  const double guess = 500 / stream_seconds(500, modes, block);
  const auto bodies = std::max<std::size_t>(1, static_cast<std::size_t>(guess));
  const double seconds = stream_seconds(bodies, modes, block);
  fmt::print("{{\"bodies\": {}}}\n", static_cast<double>(bodies) / seconds);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  using namespace carillon::bench;
  CLI::App program("one route of the sound benchmark");
  std::string route;
  std::size_t modes = 60;
  std::size_t block = 256;
  double contact_time = 1e-3;
  bool burst = false;
  bool check = false;
  program.add_option("route", route, "kernel, phasors, exponentials, stream or samples")
      ->required();
  program.add_option("--modes", modes);
  program.add_option("--block", block, "of stream");
  program.add_option("--contact-time", contact_time, "of samples [s]");
  program.add_flag("--burst", burst, "a force of samples instead of a raised cosine");
  program.add_flag("--check", check, "deviation from the sum in extended precision");
  CLI11_PARSE(program, argc, argv);
  const std::map<std::string, Sum> routes = {
      {"kernel", kernel}, {"phasors", phasors}, {"exponentials", exponentials}};
  if (routes.contains(route)) {
    sums(routes.at(route), modes, check);
  } else if (route == "stream") {
    stream(modes, block);
  } else if (route == "samples") {
    samples(modes, contact_time, burst);
  } else {
    fmt::print(stderr, "no route {}\n", route);
    return 1;
  }
}
