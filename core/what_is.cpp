#include "core/what_is.hpp"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

namespace carillon::core {

namespace fs = std::filesystem;

namespace {

constexpr const char* sound_takers =
    "features, fit, estimate, compare and identify take recordings";

WhatIs folder_kind(const fs::path& path) {
  std::error_code error;
  const auto holds = [&](const char* name) { return fs::exists(path / name, error); };
  if (holds("index.h5") || holds("configuration.yaml")) {
    return {"a dataset", fmt::format("check, regenerate, export and report take it; what it was "
                                     "made of is {}",
                                     (path / "configuration.yaml").string())};
  }
  if (holds("training.json") || fs::is_directory(path / "evaluation" / "models", error)) {
    return {"a folder of trained classifiers",
            fmt::format("carillon identify CLIP.wav --models {} takes it", path.string())};
  }
  if (holds("sweep.json")) {
    return {"a sweep",
            "report takes it; for check, regenerate and export name the folder of a variant in it"};
  }
  if (holds("accuracy.json")) return {"a study of accuracy", "carillon report takes it"};
  if (holds("nightly.json")) return {"a nightly run", "carillon report takes it"};
  if (fs::is_directory(path / "evaluation", error)) {
    return {"an evaluation", "carillon report takes it"};
  }
  if (holds("croissant.json")) return {"an export", "it was made of a dataset, which holds more"};
  return {"a folder", ""};
}

struct Magic {
  std::string_view begins;
  const char* name;
  const char* takes;
};
// First bytes, as the formats' own descriptions give them.
constexpr std::array magics = {
    Magic{"RIFF", "a WAV file", sound_takers},
    Magic{"BW64", "a WAV file", sound_takers},
    Magic{"RF64", "a WAV file", sound_takers},
    Magic{"fLaC", "a FLAC file", sound_takers},
    Magic{"OggS", "an Ogg file", sound_takers},
    Magic{"\x89PNG", "a PNG picture", ""},
    Magic{"\xff\xd8\xff", "a JPEG picture", ""},
    Magic{"\x89HDF", "an HDF5 file", ""},
    Magic{"%PDF", "a PDF file", ""},
    Magic{"PK\x03\x04", "a ZIP archive", ""},
    Magic{"\x1f\x8b", "a gzip archive", "unpack it first"},
    Magic{"\x7f"
          "ELF",
          "a program", ""},
    Magic{"glTF", "a glTF model", ""},
};

WhatIs file_kind(const fs::path& path) {
  std::array<char, 8> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  const std::string_view head(bytes.data(), static_cast<std::size_t>(file.gcount()));
  for (const Magic& magic : magics) {
    if (head.starts_with(magic.begins)) {
      return {magic.name, magic.takes, std::string_view(magic.takes) == sound_takers};
    }
  }
  const std::string extension = path.extension().string();
  if (extension == ".yaml" || extension == ".yml") {
    return {"a configuration",
            fmt::format("carillon build {} makes a dataset of it", path.string())};
  }
  return {"a file", ""};
}

}  // namespace

WhatIs what_is(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return {"missing", ""};
  if (fs::is_directory(status)) return folder_kind(path);
  if (fs::is_regular_file(status)) return file_kind(path);
  return {"no file", ""};
}

}  // namespace carillon::core
