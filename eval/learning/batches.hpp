#pragma once

#include <cstdint>
#include <future>
#include <optional>
#include <vector>

#include "eval/learning/method.hpp"
#include "eval/learning/sample_source.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval::learning {

/// Whether 16 bits a value do (learning/half.hpp): a waveform's peak is 1, and rounding stays 70 dB
/// below each value.
bool is_kept_as_halves(Modality modality);

/// Samples of one step.
struct Batch {
  std::vector<std::uint32_t> rows;
  std::vector<std::int64_t> labels;
  std::vector<std::vector<float>> modalities;  ///< of each modality rows x extent values
};

/// Rows that a rank learns from: blocks of neighbours, dealt to the ranks in turn, so that each
/// part of a file is read by one rank.
std::vector<std::uint32_t> rows_of_rank(const std::vector<std::uint32_t>& rows, int rank, int size);

/// Hands out samples in random order. What fits into memory is read once; else each pass reads
/// windows of randomly chosen blocks, the next one by another thread while the last is used.
/// What is kept as halves is handed out as it was kept.
///
/// One reader at a time may be between `begin` and its end: HDF5 takes calls from one thread.
class BatchReader {
 public:
  /// @param rows    ascending
  /// @param memory  for samples and the entries that they share [B]; the latter are all held, and
  ///                the order of samples depends on whether all fit
  /// @param method  whose modalities they are, scaled as it wants them
  /// @throws InputError  the source lacks a modality; says how to get it
  BatchReader(SampleSource& source, const LabelledSamples& samples, const Method& method,
              std::vector<std::uint32_t> rows, double memory);
  ~BatchReader();
  BatchReader(const BatchReader&) = delete;
  BatchReader& operator=(const BatchReader&) = delete;

  /// A new pass over all rows.
  /// @param order  seed of a random order; nothing: as they are numbered
  void begin(std::optional<std::uint64_t> order);
  /// The next samples, `size` of them while there are so many.
  /// @return false, and an empty batch, after the last
  /// @throws as SampleSource::read
  bool next(std::size_t size, Batch& batch);

  const std::vector<ModalityLayout>& layouts() const { return layouts_; }
  std::size_t rows() const { return rows_.size(); }
  /// Rows of the first pass of which some modality was empty: silent clips.
  std::size_t silent() const { return silent_rows_; }
  /// Time that `next` waited for files [s].
  double waited_s() const { return waited_s_; }

 private:
  /// Of one modality, one of the two: waveforms are halves.
  struct Values {
    std::vector<float> floats;
    std::vector<std::uint16_t> halves;
  };
  struct Window {
    std::vector<std::uint32_t> rows;  ///< as they are in `values`
    std::vector<Values> values;       ///< of each modality; empty where entries are shared
    std::size_t silent = 0;
  };
  Window load(std::vector<std::uint32_t> rows);
  Values load_values(std::size_t modality, std::span<const std::uint32_t> rows,
                     std::vector<bool>& heard);
  void load_shared();
  const float* shared_value(std::size_t modality, std::uint32_t row) const;
  void plan_windows(std::optional<std::uint64_t> order);
  void next_window();

  SampleSource& source_;
  const LabelledSamples& samples_;
  const std::vector<Modality> modalities_;
  const SpectrogramInput spectrogram_;
  std::vector<ModalityLayout> layouts_;
  std::vector<std::uint32_t> rows_;
  std::size_t window_rows_ = 0;
  /// What samples share of a modality; nothing where they share none.
  struct Shared {
    std::vector<std::uint32_t> of_samples;  ///< entry of each sample of the source
    std::vector<std::uint32_t> entries;     ///< those of the rows, ascending
    std::vector<float> values;
  };
  std::vector<Shared> shared_;                    ///< of each modality
  std::vector<std::vector<std::uint32_t>> plan_;  ///< rows of each window of this pass
  std::size_t window_number_ = 0;                 ///< the next of the plan
  std::optional<Window> window_;
  std::future<Window> coming_;
  std::vector<std::size_t> order_;  ///< of the window's rows
  std::size_t used_ = 0;
  std::optional<std::uint64_t> seed_;
  std::size_t silent_rows_ = 0;
  bool counted_ = false;
  double waited_s_ = 0;
};

}  // namespace carillon::eval::learning
