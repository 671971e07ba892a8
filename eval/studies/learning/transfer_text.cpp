#include <fmt/format.h>

#include <vector>

#include "eval/studies/learning/detail/tables.hpp"
#include "eval/studies/learning/detail/transfer.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;

namespace {

const char* name_of(LearntFrom kind) {
  switch (kind) {
    case LearntFrom::elsewhere:
      return "elsewhere";
    case LearntFrom::target:
      return "target";
    case LearntFrom::mixed:
      return "mixed";
    case LearntFrom::alone:
      return "alone";
  }
  return "";
}

}  // namespace

ordered_json transfer_document(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                               const std::vector<TransferRow>& rows) {
  ordered_json document = {{"name", datasets.name()},
                           {"task", spec.task.name},
                           {"split", spec.task.split},
                           {"target", spec.target.name},
                           {"against", datasets.conditions()[spec.against].name},
                           {"mixed_with", nullptr},
                           {"seeds", spec.seeds},
                           {"rows", ordered_json::array()}};
  if (spec.mixed_with) {
    document["mixed_with"] = datasets.conditions()[*spec.mixed_with].name;
  }
  for (const TransferRow& row : rows) {
    ordered_json line = {{"kind", name_of(row.kind)}, {"trained_on", row.trained_on},
                         {"method", row.method},      {"fraction", row.fraction},
                         {"samples", row.samples},    {"own", row.own},
                         {"target", row.there},       {"less_home", row.less_home},
                         {"gain", row.gain},          {"confusion_norm", nullptr},
                         {"norm_by_chance", nullptr}, {"compared_classes", row.compared_classes},
                         {"heard", nullptr},          {"sample_s", nullptr}};
    if (row.confusion_norm) {
      line["confusion_norm"] = *row.confusion_norm;
      line["norm_by_chance"] = {{"mean", row.norm_by_chance.mean},
                                {"most", row.norm_by_chance.most}};
    }
    if (row.heard) line["heard"] = to_json(*row.heard);
    if (row.sample_s) line["sample_s"] = *row.sample_s;
    document["rows"].push_back(std::move(line));
  }
  return document;
}

namespace {

std::string figure(const ordered_json& number, double scale, int digits) {
  return number.is_null() ? "-" : fmt::format("{:.{}f}", scale * number.get<double>(), digits);
}

/// How different each dataset's sounds are from the target's; empty where none was compared.
std::string heard_text(const ordered_json& document) {
  std::vector<std::vector<std::string>> lines = {
      {"dataset", "sounds", "pitch", "decay", "level", "energy matched", "loudness apart"}};
  for (const ordered_json& row : document.at("rows")) {
    const std::string dataset = row.at("trained_on");
    const ordered_json& heard = row.at("heard");
    if (heard.is_null() || lines.back().front() == dataset) continue;
    lines.push_back({dataset, fmt::format("{}", heard.at("sounds").get<std::size_t>()),
                     figure(heard.at("pitch_jnd"), 1, 2), figure(heard.at("decay_jnd"), 1, 2),
                     figure(heard.at("level_jnd"), 1, 2),
                     figure(heard.at("matched_fraction"), 100, 1),
                     figure(heard.at("loudness_fraction"), 100, 1)});
  }
  if (lines.size() == 1) return "";
  return "\nThe same strikes in the target, to a listener: medians of errors of modes in "
         "just-noticeable differences, of the target's energy in modes that are matched, and of "
         "the difference in sone/Bark; percent.\n\n" +
         markdown(lines);
}

}  // namespace

std::string transfer_text(const ordered_json& document) {
  std::vector<std::vector<std::string>> elsewhere = {
      {"trained on", "method", "samples", "accuracy there", "in the target",
       "less what its own teach", "gain", "confusions apart", "by chance", "ms a sample"}};
  std::vector<std::vector<std::string>> mixes = {
      {"of the target", "method", "with", "samples", "in the target", "less what all teach"}};
  for (const ordered_json& row : document.at("rows")) {
    const std::string trained_on = row.at("trained_on");
    const std::string samples = fmt::format("{}", row.at("samples").get<std::size_t>());
    if (const std::string kind = row.at("kind"); kind == "mixed" || kind == "alone") {
      mixes.push_back(
          {fmt::format("{:.0f} %", 100 * row.at("share").get<double>()), row.at("method"),
           kind == "mixed" ? document.at("mixed_with").get<std::string>() : "-", samples,
           with_interval(row.at("target")), with_interval(row.at("less_home"))});
      continue;
    }
    const ordered_json& norm = row.at("confusion_norm");
    const ordered_json& seconds = row.at("sample_s");
    elsewhere.push_back(
        {trained_on, row.at("method"), samples, with_interval(row.at("own")),
         with_interval(row.at("target")), with_interval(row.at("less_home")),
         with_interval(row.at("gain")),
         norm.is_null() ? "-"
                        : fmt::format("{:.3f} of {} classes", norm.get<double>(),
                                      row.at("compared_classes").get<std::size_t>()),
         norm.is_null()
             ? "-"
             : fmt::format("up to {:.3f}", row.at("norm_by_chance").at("most").get<double>()),
         seconds.is_null() ? "-" : fmt::format("{:.1f}", 1e3 * seconds.get<double>())});
  }
  std::string text =
      fmt::format("# {}: {} in {}\n", document.at("name").get<std::string>(),
                  document.at("task").get<std::string>(), document.at("target").get<std::string>());
  if (elsewhere.size() > 1) {
    text += fmt::format(
        "\nLearnt in one condition, tested where it learnt and in the target; gains over {}; "
        "percent.\n\n{}",
        document.at("against").get<std::string>(), markdown(elsewhere));
  }
  text += heard_text(document);
  if (mixes.size() > 1) {
    text += "\nTraining sets with fractions of the target's own samples; percent.\n\n" +
            markdown(mixes);
  }
  return text;
}

}  // namespace carillon::eval::studies
