#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "dataset/configuration/about.hpp"

namespace carillon::dataset::run {

/// What a description says that a configuration does: the name and what `about` holds.
nlohmann::ordered_json croissant_about(const std::string& name, const configuration::About& about);

/// A description of a dataset in MLCommons' Croissant format 1.1 (JSON-LD), without its files and
/// records. What `about` does not say is left out, but for the description.
/// @param what  a sentence for a dataset whose `about` has no description
nlohmann::ordered_json croissant_head(const std::string& name, const configuration::About& about,
                                      const std::string& what);

/// A FileObject, named and found by its path from the description, its type told by its ending.
nlohmann::ordered_json croissant_file(const std::string& path, const std::string& sha256,
                                      std::uintmax_t bytes);
/// A FileSet of all files whose paths match.
nlohmann::ordered_json croissant_files(const std::string& id, const std::string& mime_type,
                                       const nlohmann::ordered_json& includes);

/// A RecordSet whose records are told apart by their field `key`.
nlohmann::ordered_json croissant_records(const std::string& id, const std::string& description,
                                         nlohmann::ordered_json fields);

/// A field of a RecordSet.
/// @param type    a schema.org class such as sc:Text
/// @param source  where its values come from; null: not said
nlohmann::ordered_json croissant_field(const std::string& record_set, const std::string& name,
                                       const std::string& type, const std::string& description,
                                       const nlohmann::ordered_json& source);

/// What a field says of a column. @param unit  "1": a number alone, or a text
std::string croissant_column_text(const std::string& name, const std::string& unit);

/// What stands for a description where none was given.
std::string samples_sentence(std::size_t samples);

/// croissant.json of a dataset: its files with their checksums, and a record for each sample of
/// index.h5. Croissant 1.1 names no way into HDF5 files: a field's `column` is the array's name.
/// @param description  dataset.json
nlohmann::ordered_json dataset_croissant(const std::filesystem::path& folder,
                                         const nlohmann::json& description);

/// sc:Text, sc:Integer or sc:Float, of elements as core::Hdf5Group::element_type names them.
std::string croissant_type(const std::string& element_type);

}  // namespace carillon::dataset::run
