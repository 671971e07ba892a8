#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/exporters/seal.hpp"

namespace carillon::eval::scoring {

/// A test object in one of its materials and sizes, as it was computed.
struct TrueObject {
  std::string name;                  ///< shape/material/size, as the keys of its samples begin
  std::vector<double> eigenvalues;   ///< lambda [rad^2/s^2], ascending
  std::vector<double> pitch_errors;  ///< estimated [cent]; empty where none were
  std::vector<double> decay_rates;   ///< of the material alone [1/s]
  std::vector<double> alphas;        ///< alpha1, alpha2 of Rayleigh damping; empty of other laws
};

/// The objects that a dataset holds out (`split_shape`), and what tells them.
struct TrueObjects {
  std::string dataset;
  std::vector<TrueObject> objects;            ///< by name
  std::map<std::string, std::size_t> sample;  ///< of each sample of theirs, its object, by id
};

/// @param seal  of an export that hides labels: its samples' ids are known, too
/// @throws InputError, ConfigError, FileError  it is no dataset, its modes are not there, or
///                                             nothing is held out
TrueObjects open_true_objects(const std::filesystem::path& folder,
                              const std::optional<dataset::exporters::Seal>& seal);

}  // namespace carillon::eval::scoring
