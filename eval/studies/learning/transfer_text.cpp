#include <fmt/format.h>

#include <vector>

#include "eval/scoring/tables.hpp"
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

ordered_json transfer_json(const TransferSpec& spec, const EvaluatedDatasets& datasets,
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
    ordered_json line = {{"kind", name_of(row.kind)},
                         {"trained_on", row.trained_on},
                         {"method", row.method},
                         {"fraction", row.fraction},
                         {"samples", row.samples},
                         {"own", scoring::accuracy_json(row.own)},
                         {"target", scoring::accuracy_json(row.there)},
                         {"target_balanced", scoring::accuracy_json(row.balanced_there)},
                         {"target_unknown", nullptr},
                         {"classes", row.classes},
                         {"target_confusion", scoring::counts_json(row.confusion_there)},
                         {"less_home", to_json(row.less_home)},
                         {"gain", to_json(row.gain)},
                         {"confusion_norm", nullptr},
                         {"norm_by_chance", nullptr},
                         {"compared_classes", row.compared_classes},
                         {"heard", nullptr},
                         {"sample_s", nullptr}};
    if (row.confusion_norm) {
      line["confusion_norm"] = *row.confusion_norm;
      line["norm_by_chance"] = {{"mean", row.norm_by_chance.mean}, {"max", row.norm_by_chance.max}};
    }
    if (row.unknown_there) line["target_unknown"] = *row.unknown_there;
    if (row.heard) line["heard"] = to_json(*row.heard);
    if (row.sample_s) line["sample_s"] = *row.sample_s;
    document["rows"].push_back(std::move(line));
  }
  return document;
}

namespace {

/// How different each dataset's sounds are from the target's; empty where none was compared.
std::string heard_text(const std::vector<TransferRow>& rows) {
  std::vector<std::vector<std::string>> lines = {
      {"dataset", "sounds", "pitch", "decay", "level", "energy matched", "loudness apart"}};
  for (const TransferRow& row : rows) {
    if (!row.heard || lines.back().front() == row.trained_on) continue;
    const HeardDifference& heard = *row.heard;
    lines.push_back({row.trained_on, fmt::format("{}", heard.sounds),
                     scoring::figure(heard.pitch, 2), scoring::figure(heard.decay, 2),
                     scoring::figure(heard.level, 2), scoring::figure(100 * heard.matched, 1),
                     scoring::figure(100 * heard.loudness, 1)});
  }
  if (lines.size() == 1) return "";
  return "\nThe same strikes in the target, to a listener: medians of errors of modes in "
         "just-noticeable differences, of the target's energy in modes that are matched, and of "
         "the difference in sone/Bark; percent.\n\n" +
         scoring::markdown(lines);
}

}  // namespace

std::string transfer_text(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                          const std::vector<TransferRow>& rows) {
  std::vector<std::vector<std::string>> elsewhere = {
      {"trained on", "method", "samples", "accuracy there", "in the target", "balanced",
       "none of its classes", "less what its own teach", "gain", "confusions apart", "by chance",
       "ms a sample"}};
  std::vector<std::vector<std::string>> mixes = {
      {"of the target", "method", "with", "samples", "in the target", "less what all teach"}};
  for (const TransferRow& row : rows) {
    const std::string samples = fmt::format("{}", row.samples);
    if (row.kind == LearntFrom::mixed || row.kind == LearntFrom::alone) {
      mixes.push_back(
          {fmt::format("{:.0f} %", 100 * row.fraction), row.method,
           row.kind == LearntFrom::mixed ? datasets.conditions()[*spec.mixed_with].name : "-",
           samples, scoring::with_interval(row.there), scoring::with_interval(row.less_home)});
      continue;
    }
    elsewhere.push_back(
        {row.trained_on, row.method, samples, scoring::with_interval(row.own),
         scoring::with_interval(row.there), scoring::with_interval(row.balanced_there),
         row.unknown_there ? fmt::format("{:.1f}", 100 * *row.unknown_there) : "-",
         scoring::with_interval(row.less_home), scoring::with_interval(row.gain),
         row.confusion_norm
             ? fmt::format("{:.3f} of {} classes", *row.confusion_norm, row.compared_classes)
             : "-",
         row.confusion_norm ? fmt::format("up to {:.3f}", row.norm_by_chance.max) : "-",
         row.sample_s ? fmt::format("{:.1f}", 1e3 * *row.sample_s) : "-"});
  }
  std::string text =
      fmt::format("# {}: {} in {}\n", datasets.name(), spec.task.name, spec.target.name);
  if (elsewhere.size() > 1) {
    text += fmt::format(
        "\nLearnt in one condition, tested where it learnt and in the target; gains over {}; "
        "percent.\n\n{}",
        datasets.conditions()[spec.against].name, scoring::markdown(elsewhere));
  }
  text += heard_text(rows);
  if (mixes.size() > 1) {
    text += "\nTraining sets with fractions of the target's own samples; percent.\n\n" +
            scoring::markdown(mixes);
  }
  return text;
}

}  // namespace carillon::eval::studies
