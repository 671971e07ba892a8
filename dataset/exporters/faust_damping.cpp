#include <fmt/format.h>

#include <algorithm>

#include "dataset/exporters/faust_program.hpp"

namespace carillon::dataset::exporters {

namespace {

constexpr double nano = 1e-9;

/// A slider of a Rayleigh parameter: two decades to both sides, or from nothing on.
std::string parameter_slider(const char* label, double value, double usual) {
  return value > 0
             ? faust_slider(fmt::format("{}[scale:log]", label), value, value / 100, value * 100)
             : faust_slider(label, 0, 0, usual);
}

std::string factor_slider(const char* label) {
  return faust_slider(fmt::format("{}[scale:log]", label), 1, 0.01, 100);
}

FaustDamping rayleigh_of_one(const synth::damping::DampingModel& model) {
  FaustDamping damping;
  damping.definitions = fmt::format(
      "alpha1 = {};\n"
      "alpha2 = {} * {};\n"
      "rate(lambda) = (alpha1 + alpha2*lambda)/2;\n",
      parameter_slider("v:object/[3]alpha1[unit:1/s]", model.parameters[0], 1000),
      parameter_slider("v:object/[4]alpha2[unit:ns]", model.parameters[1] / nano, 1000),
      faust_number(nano));
  return damping;
}

/// c = sum over regions of alpha1 kinetic_fraction + alpha2 lambda strain_fraction.
FaustDamping rayleigh_of_regions(const solvers::modes::Modes& modes,
                                 std::span<const synth::material::Material> materials) {
  FaustDamping damping;
  damping.definitions = fmt::format(
      "alpha1 = {};\n"
      "alpha2 = {};\n"
      "rate(alpha1_of, alpha2_of, lambda) = (alpha1*alpha1_of + alpha2*alpha2_of*lambda)/2;\n",
      factor_slider("v:object/[3]alpha1 of all materials, times"),
      factor_slider("v:object/[4]alpha2 of all materials, times"));
  damping.columns = {{"alpha1s", {}}, {"alpha2s", {}}};
  for (Eigen::Index i = 0; i < modes.kinetic_fraction.rows(); ++i) {
    double alpha1 = 0, alpha2 = 0;
    for (std::size_t r = 0; r < materials.size(); ++r) {
      const auto region = static_cast<Eigen::Index>(r);
      alpha1 += materials[r].damping.parameters[0] * modes.kinetic_fraction(i, region);
      alpha2 += materials[r].damping.parameters[1] * modes.strain_fraction(i, region);
    }
    damping.columns[0].values.push_back(alpha1);
    damping.columns[1].values.push_back(alpha2);
  }
  return damping;
}

/// c(lambda) of a model of one region as Faust writes it; empty for an expression.
std::string formula(const synth::damping::DampingModel& model) {
  std::vector<std::string> alpha;
  for (const double value : model.parameters) alpha.push_back(faust_number(value));
  switch (model.kind) {
    case synth::damping::DampingKind::power:
      return fmt::format("{}*pow(lambda, {})", alpha[0], alpha[1]);
    case synth::damping::DampingKind::hybrid:
      return fmt::format("{} + {}*pow(lambda, {})", alpha[0], alpha[1], alpha[2]);
    case synth::damping::DampingKind::rayleigh:
    case synth::damping::DampingKind::caughey: {
      std::string sum = alpha.back();  // Horner's scheme
      for (std::size_t k = alpha.size() - 1; k-- > 0;) {
        sum = fmt::format("{} + lambda*({})", alpha[k], sum);
      }
      return sum;
    }
    case synth::damping::DampingKind::expression:
      return "";
  }
  return "";
}

}  // namespace

FaustDamping faust_damping(const solvers::modes::Modes& modes,
                           std::span<const synth::material::Material> materials,
                           std::span<const double> rates) {
  const bool rayleigh = std::all_of(materials.begin(), materials.end(), [](const auto& material) {
    return material.damping.kind == synth::damping::DampingKind::rayleigh;
  });
  if (rayleigh && materials.size() == 1) return rayleigh_of_one(materials.front().damping);
  if (rayleigh) return rayleigh_of_regions(modes, materials);

  const std::string c = materials.size() == 1 ? formula(materials.front().damping) : "";
  if (!c.empty()) return {fmt::format("rate(lambda) = max(0, {})/2;\n", c), {}};
  return {"rate(d, lambda) = d;\n", {{"rates", {rates.begin(), rates.end()}}}};
}

}  // namespace carillon::dataset::exporters
