#include "eval/learning/batches.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include "core/random.hpp"
#include "core/trace.hpp"
#include "eval/learning/half.hpp"

namespace carillon::eval::learning {

namespace {

/// Rows that are read in one go: about a chunk of a shard.
constexpr std::size_t block_rows = 64;

template <class T>
void shuffle(std::vector<T>& values, core::RandomStream& random) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[random.index(i)]);
}

}  // namespace

bool is_kept_as_halves(Modality modality) {
  return modality == Modality::waveform;
}

std::vector<std::uint32_t> rows_of_rank(const std::vector<std::uint32_t>& rows, int rank,
                                        int size) {
  const auto ranks = static_cast<std::size_t>(size);
  // Small enough that no rank has much more than another.
  const std::size_t block = std::clamp<std::size_t>(rows.size() / (16 * ranks), 1, block_rows);
  std::vector<std::uint32_t> own;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i / block % ranks == static_cast<std::size_t>(rank)) own.push_back(rows[i]);
  }
  return own;
}

BatchReader::BatchReader(SampleSource& source, const LabelledSamples& samples, const Method& method,
                         std::vector<std::uint32_t> rows, double memory)
    : source_(source),
      samples_(samples),
      modalities_(method.modalities),
      spectrogram_(method.spectrogram),
      rows_(std::move(rows)),
      shared_(modalities_.size()) {
  double row_bytes = 1;
  for (std::size_t s = 0; s < modalities_.size(); ++s) {
    const ModalityLayout layout = require_layout(source, modalities_[s]);
    layouts_.push_back(layout);
    const double bytes =
        static_cast<double>(values_in(layout.extent)) * (is_kept_as_halves(modalities_[s]) ? 2 : 4);
    if (!layout.shared) {
      row_bytes += bytes;
      continue;
    }
    Shared& shared = shared_[s];
    shared.of_samples = source.entries_of(modalities_[s]);
    std::set<std::uint32_t> named;
    for (const std::uint32_t row : rows_) named.insert(shared.of_samples[row]);
    shared.entries.assign(named.begin(), named.end());
    // They are all there at once: samples of each lie anywhere.
    memory -= bytes * static_cast<double>(shared.entries.size());
  }
  const auto fitting = static_cast<std::size_t>(std::max(1.0, memory / row_bytes));
  // Two windows are there at a time: one in use, one coming.
  window_rows_ = fitting >= rows_.size()
                     ? rows_.size()
                     : std::max(block_rows, fitting / 2 / block_rows * block_rows);
}

BatchReader::~BatchReader() {
  if (coming_.valid()) coming_.wait();
}

BatchReader::Values BatchReader::load_values(std::size_t modality,
                                             std::span<const std::uint32_t> rows,
                                             std::vector<bool>& heard) {
  const bool halves = is_kept_as_halves(modalities_[modality]);
  const std::size_t each = values_in(layouts_[modality].extent);
  Values values;
  (halves ? values.halves.resize(rows.size() * each) : values.floats.resize(rows.size() * each));
  std::vector<float> block(halves ? std::min(block_rows, rows.size()) * each : 0);
  // Rows rise within a block.
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t end = first + 1;
    while (end < rows.size() && end - first < block_rows && rows[end] > rows[end - 1]) ++end;
    const std::size_t at = first * each, count = (end - first) * each;
    const std::span<float> to =
        halves ? std::span(block).first(count) : std::span(values.floats).subspan(at, count);
    const std::vector<bool> full =
        source_.read(modalities_[modality], rows.subspan(first, end - first), to);
    if (halves) to_half(to, std::span(values.halves).subspan(at, count));
    for (std::size_t i = 0; i < full.size(); ++i) heard[first + i] = heard[first + i] && full[i];
    first = end;
  }
  return values;
}

BatchReader::Window BatchReader::load(std::vector<std::uint32_t> rows) {
  Window window;
  window.rows = std::move(rows);
  std::vector<bool> heard(window.rows.size(), true);
  for (std::size_t s = 0; s < modalities_.size(); ++s) {
    window.values.push_back(layouts_[s].shared ? Values{} : load_values(s, window.rows, heard));
    if (modalities_[s] == Modality::spectrogram) spectrogram_.apply(window.values[s].floats);
  }
  window.silent = static_cast<std::size_t>(std::count(heard.begin(), heard.end(), false));
  return window;
}

void BatchReader::load_shared() {
  for (std::size_t s = 0; s < modalities_.size(); ++s) {
    Shared& shared = shared_[s];
    if (!layouts_[s].shared || !shared.values.empty()) continue;
    const std::size_t each = values_in(layouts_[s].extent), count = shared.entries.size();
    shared.values.resize(count * each);
    for (std::size_t first = 0; first < count; first += block_rows) {
      const auto entries =
          std::span(shared.entries).subspan(first, std::min(block_rows, count - first));
      source_.read(modalities_[s], entries,
                   std::span(shared.values).subspan(first * each, entries.size() * each));
    }
  }
}

/// What a sample shares with others of a modality.
const float* BatchReader::shared_value(std::size_t modality, std::uint32_t row) const {
  const Shared& shared = shared_[modality];
  const auto at =
      std::lower_bound(shared.entries.begin(), shared.entries.end(), shared.of_samples[row]) -
      shared.entries.begin();
  return shared.values.data() + static_cast<std::size_t>(at) * values_in(layouts_[modality].extent);
}

/// Blocks in random order, as many to a window as it holds.
void BatchReader::plan_windows(std::optional<std::uint64_t> order) {
  plan_.clear();
  std::vector<std::size_t> blocks((rows_.size() + block_rows - 1) / block_rows);
  std::iota(blocks.begin(), blocks.end(), std::size_t{0});
  if (order) {
    core::RandomStream random(*order, 0, "learning.blocks");
    shuffle(blocks, random);
  }
  for (const std::size_t block : blocks) {
    if (plan_.empty() || plan_.back().size() + block_rows > window_rows_) plan_.emplace_back();
    const auto first = rows_.begin() + static_cast<std::ptrdiff_t>(block * block_rows);
    const auto end = rows_.begin() +
                     static_cast<std::ptrdiff_t>(std::min(rows_.size(), (block + 1) * block_rows));
    plan_.back().insert(plan_.back().end(), first, end);
  }
}

void BatchReader::begin(std::optional<std::uint64_t> order) {
  if (coming_.valid()) coming_.wait();
  coming_ = {};
  load_shared();
  seed_ = order;
  window_number_ = 0;
  used_ = 0;
  order_.clear();
  if (!counted_) silent_rows_ = 0;
  if (window_rows_ >= rows_.size()) {
    plan_ = {rows_};  // whole, in the order of the file; kept from pass to pass
  } else {
    plan_windows(order);
    window_.reset();
  }
}

void BatchReader::next_window() {
  const double start = core::monotonic_seconds();
  if (!(window_ && window_->rows == plan_[window_number_])) {
    window_ = coming_.valid() ? coming_.get() : load(plan_[window_number_]);
    if (!counted_) silent_rows_ += window_->silent;
  }
  waited_s_ += core::monotonic_seconds() - start;
  order_.resize(window_->rows.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (seed_) {
    core::RandomStream random(*seed_, window_number_, "learning.rows");
    shuffle(order_, random);
  }
  used_ = 0;
  ++window_number_;
  if (window_number_ < plan_.size()) {
    coming_ = std::async(std::launch::async, [this, rows = plan_[window_number_]]() mutable {
      return load(std::move(rows));
    });
  }
}

bool BatchReader::next(std::size_t size, Batch& batch) {
  batch.rows.clear();
  batch.labels.clear();
  batch.modalities.assign(modalities_.size(), {});
  while (batch.rows.size() < size) {
    if (used_ == order_.size()) {
      if (window_number_ == plan_.size() || rows_.empty()) break;
      next_window();
    }
    const std::size_t at = order_[used_++];
    const std::uint32_t row = window_->rows[at];
    batch.rows.push_back(row);
    batch.labels.push_back(samples_.label[row]);
    for (std::size_t s = 0; s < modalities_.size(); ++s) {
      const std::size_t each = values_in(layouts_[s].extent);
      std::vector<float>& to = batch.modalities[s];
      if (is_kept_as_halves(modalities_[s])) {
        to.resize(to.size() + each);
        from_half(std::span(window_->values[s].halves).subspan(at * each, each),
                  std::span(to).last(each));
        continue;
      }
      const float* from =
          layouts_[s].shared ? shared_value(s, row) : window_->values[s].floats.data() + at * each;
      to.insert(to.end(), from, from + each);
    }
  }
  if (window_number_ == plan_.size() && used_ == order_.size()) counted_ = true;
  return !batch.rows.empty();
}

}  // namespace carillon::eval::learning
