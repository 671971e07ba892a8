#include "eval/learning/recordings_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/random.hpp"
#include "eval/learning/clip.hpp"

namespace carillon::eval::learning {

namespace {

namespace fs = std::filesystem;

/// Files and their labels, in the order of the files' names.
struct LabelTable {
  std::vector<std::string> files;
  std::map<std::string, std::vector<std::string>> columns;
};

bool is_audio(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".wav" || extension == ".flac" || extension == ".aif" ||
         extension == ".aiff" || extension == ".ogg";
}

std::vector<std::string> audio_files(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    if (at->is_regular_file() && is_audio(at->path())) {
      // As it is called there: links to files are not followed.
      files.push_back(at->path().lexically_relative(folder).generic_string());
    }
  }
  if (error) throw core::FileError(fmt::format("{}: {}", folder.string(), error.message()));
  std::sort(files.begin(), files.end());
  return files;
}

/// A pattern of names as a regular expression, with the names of its groups: once with labels as
/// short as they can be, once as long.
struct NamePattern {
  std::regex shortest, longest;
  std::vector<std::string> labels;
};

NamePattern compile(const std::string& pattern) {
  NamePattern compiled;
  std::string text, longest;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char c = pattern[i];
    if (c == '{') {
      const std::size_t end = pattern.find('}', i);
      const std::string label = end == std::string::npos ? "" : pattern.substr(i + 1, end - i - 1);
      if (label.empty() || std::find(compiled.labels.begin(), compiled.labels.end(), label) !=
                               compiled.labels.end()) {
        throw core::InputError(fmt::format("the names \"{}\" cannot be read", pattern),
                               "each label once, in braces: {material}/{shape}-*.wav");
      }
      compiled.labels.push_back(label);
      text += "([^/]+?)";
      longest += "([^/]+)";
      i = end;
      continue;
    }
    std::string piece(1, c);
    if (c == '*') piece = "[^/]*?";
    if (std::string_view("\\^$.|?+()[]}").find(c) != std::string_view::npos) piece.insert(0, "\\");
    text += piece;
    longest += piece;
  }
  if (compiled.labels.empty()) {
    throw core::InputError(fmt::format("the names \"{}\" hold no label", pattern),
                           "labels stand in braces: {material}/{shape}-*.wav");
  }
  const std::string extension = is_audio(pattern) ? "" : "\\.[^./]+";
  compiled.shortest = std::regex(text + extension, std::regex::icase);
  compiled.longest = std::regex(longest + extension, std::regex::icase);
  return compiled;
}

LabelTable labels_of_names(const RecordingsSpec& spec) {
  const NamePattern pattern = compile(spec.names);
  LabelTable table{audio_files(spec.folder), {}};
  for (const std::string& file : table.files) {
    std::smatch match, other;
    if (!std::regex_match(file, match, pattern.shortest) ||
        !std::regex_match(file, other, pattern.longest)) {
      throw core::InputError(
          fmt::format("{}: {} does not fit the names \"{}\"", spec.folder.string(), file,
                      spec.names),
          "give a table (CSV with a column file) where names follow no one pattern");
    }
    for (std::size_t i = 0; i < pattern.labels.size(); ++i) {
      if (match[i + 1] != other[i + 1]) {
        throw core::InputError(
            fmt::format("{}: the {} of {} may be {} or {}", spec.folder.string(), pattern.labels[i],
                        file, match[i + 1].str(), other[i + 1].str()),
            "give a table (CSV with a column file) where labels hold what stands between them");
      }
      table.columns[pattern.labels[i]].push_back(match[i + 1]);
    }
  }
  return table;
}

LabelTable labels_of_table(const RecordingsSpec& spec) {
  const core::CsvTable csv = core::read_csv(spec.table, '\0');
  const std::vector<std::string>& header = csv.head.cells;
  if (header.empty()) return {};
  const auto refuse = [](const core::CsvRow& row, const std::string& why) {
    throw core::InputError(fmt::format("{}: {}", row.place, why));
  };
  for (std::size_t c = 0; c < header.size(); ++c) {
    if (header[c].empty()) refuse(csv.head, fmt::format("column {} has no name", c + 1));
    if (std::count(header.begin(), header.end(), header[c]) > 1) {
      refuse(csv.head, fmt::format("column \"{}\" stands here twice", header[c]));
    }
  }
  const auto named = csv.column("file");
  if (!named) refuse(csv.head, "the header has no column \"file\"");
  std::map<std::string, std::vector<std::string>> rows;  // by file
  for (const core::CsvRow& row : csv.rows) {
    if (row.cells.size() != header.size()) {
      refuse(row, fmt::format("{} cells, the header has {}", row.cells.size(), header.size()));
    }
    const std::string& file = row.cells[*named];
    if (!fs::is_regular_file(spec.folder / file)) {
      refuse(row, fmt::format("there is no {}", (spec.folder / file).string()));
    }
    if (!rows.emplace(file, row.cells).second) {
      refuse(row, fmt::format("{} stands here twice", file));
    }
  }
  LabelTable table;
  for (const auto& [file, cells] : rows) {
    table.files.push_back(file);
    for (std::size_t c = 0; c < header.size(); ++c) {
      if (header[c] != "file") table.columns[header[c]].push_back(cells[c]);
    }
  }
  return table;
}

class RecordingsSource final : public SampleSource {
 public:
  RecordingsSource(const RecordingsSpec& spec, const ClipFormat& format)
      : spec_(spec),
        name_(spec.folder.string()),
        table_(spec.table.empty() ? labels_of_names(spec) : labels_of_table(spec)),
        preparer_(format) {
    if (table_.files.empty()) {
      throw core::InputError(fmt::format("{}: no recordings", name_),
                             "WAV, FLAC, AIFF or Ogg files, in folders or not");
    }
    require_utf8();
    core::Sha256 all;
    for (const std::string& file : table_.files) {
      hashes_.push_back(core::sha256_file(spec.folder / file));
      all.add(file).add(hashes_.back());
    }
    for (const auto& [column, cells] : table_.columns) {
      all.add(column);
      for (const std::string& cell : cells) all.add(cell).add("\n");
    }
    content_ = fmt::format("{} {} {} {} {} {} {}", all.hex(), to_json(preparer_.format()).dump(),
                           spec.object, spec.strike, spec.validation, spec.test, spec.seed);
    name_objects();
  }

  const std::string& name() const override { return name_; }
  std::size_t size() const override { return table_.files.size(); }
  std::vector<std::string> keys() const override { return table_.files; }
  std::vector<std::string> object_names() const override { return object_names_; }
  std::vector<std::string> strike_names() const override { return strike_names_; }
  std::string content() const override { return content_; }

  std::optional<ClipFormat> clip_format() const override { return preparer_.format(); }

  std::vector<std::string> labels(const std::string& column) const override {
    if (column == "split_shape" || column == "split_strike") return checked_split(column);
    if (const auto found = table_.columns.find(column); found != table_.columns.end()) {
      return found->second;
    }
    std::vector<std::string> there;
    for (const auto& [name, cells] : table_.columns) there.push_back(name);
    throw core::InputError(fmt::format("{}: no column \"{}\"", name_, column),
                           fmt::format("there are {}", fmt::join(there, ", ")));
  }

  std::vector<std::uint32_t> entries_of(Modality) const override { return {}; }  // shares none
  std::optional<ModalityLayout> layout(Modality modality) const override {
    if (modality != Modality::spectrogram && modality != Modality::waveform) return std::nullopt;
    return ModalityLayout{preparer_.extent(modality), size(), false};
  }

  std::vector<bool> read(Modality modality, std::span<const std::uint32_t> entries,
                         std::span<float> values) override {
    std::vector<bool> heard;
    const std::size_t each = entries.empty() ? 0 : values.size() / entries.size();
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::string& file = table_.files[entries[i]];
      try {
        const std::vector<float> clip =
            strike_clip(core::read_audio(spec_.folder / file), preparer_.format());
        heard.push_back(preparer_.prepare(modality, clip, values.subspan(i * each, each)));
      } catch (const core::InputError& error) {
        throw core::InputError(fmt::format("{}: {}: {}", name_, file, error.message()),
                               error.hint());
      }
    }
    return heard;
  }

 private:
  /// Names and labels go into JSON.
  void require_utf8() const {
    const auto require = [&](const std::string& text, const std::string& file) {
      try {
        static_cast<void>(nlohmann::json(text).dump());
      } catch (const nlohmann::json::exception&) {
        throw core::InputError(
            fmt::format(
                "{}: a name or label of {} is not UTF-8", name_,
                nlohmann::json(file).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace)),
            "save the table as UTF-8");
      }
    };
    for (const std::string& file : table_.files) require(file, file);
    for (const auto& [column, cells] : table_.columns) {
      require(column, table_.files.front());
      for (std::size_t i = 0; i < cells.size(); ++i) require(cells[i], table_.files[i]);
    }
  }

  void name_objects() {
    std::string column = spec_.object;
    if (column.empty() && table_.columns.contains("shape")) column = "shape";
    strike_names_ = hashes_;
    object_names_ = column.empty() ? hashes_ : labels(column);
    if (!spec_.strike.empty()) {
      strike_names_ = labels(spec_.strike);
      if (column.empty()) object_names_ = strike_names_;
      for (std::size_t i = 0; i < size(); ++i) strike_names_[i].insert(0, object_names_[i] + " ");
    }
  }

  std::string drawn_part(const std::string& identity, const std::string& split) const {
    const double draw =
        core::RandomStream(spec_.seed, core::stable_hash(identity), split).uniform();
    if (draw < spec_.test) return "test";
    return draw < spec_.test + spec_.validation ? "validation" : "train";
  }

  /// The table's own column, or parts that are drawn: of objects, or of sounds.
  std::vector<std::string> split_of(const std::string& column) const {
    for (const std::string& own : {column, std::string("split")}) {
      if (const auto found = table_.columns.find(own); found != table_.columns.end()) {
        return found->second;
      }
    }
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < size(); ++i) {
      parts.push_back(
          drawn_part(column == "split_shape" ? object_names_[i] : strike_names_[i], column));
    }
    return parts;
  }

  std::vector<std::string> checked_split(const std::string& column) const {
    const std::vector<std::string> parts = split_of(column);
    std::map<std::string, std::size_t> first_of;
    const auto require_one_part = [&](const std::string& identity, std::size_t i,
                                      const std::string& what) {
      const std::size_t first = first_of.emplace(identity, i).first->second;
      if (parts[first] == parts[i]) return;
      throw core::InputError(
          fmt::format("{}: {} leaks from one part into another: {} ({} and {})", name_, column,
                      what, table_.files[first], table_.files[i]),
          column == "split_shape"
              ? "put both into one part, or learn by strikes: split_column: split_strike of the "
                "task"
              : "what is learnt from it would seem better than it is: put both into one part");
    };
    for (std::size_t i = 0; i < size(); ++i) {
      require_one_part("sound " + hashes_[i], i, "the same sound twice");
      require_one_part("strike " + strike_names_[i], i, "one strike");
      if (column == "split_shape") {
        require_one_part("object " + object_names_[i], i, "object " + object_names_[i]);
      }
    }
    return parts;
  }

  RecordingsSpec spec_;
  std::string name_;
  LabelTable table_;
  ClipPreparer preparer_;
  std::vector<std::string> hashes_;
  std::vector<std::string> object_names_, strike_names_;
  std::string content_;
};

}  // namespace

std::unique_ptr<SampleSource> open_recordings(const RecordingsSpec& spec,
                                              const std::optional<ClipFormat>& format) {
  const auto samples = static_cast<std::size_t>(std::llround(spec.seconds * spec.sample_rate));
  return std::make_unique<RecordingsSource>(
      spec, format.value_or(paper_format(samples, spec.sample_rate)));
}

}  // namespace carillon::eval::learning
