#pragma once

#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "eval/learning/epochs.hpp"
#include "eval/learning/method.hpp"
#include "eval/learning/sample_source.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval::networks {

/// Ranks that learn together. What stands here fits one that is alone.
struct LearningRanks {
  int rank = 0;
  int size = 1;
  /// Sums over all ranks, element by element, the same on all of them. Collective.
  std::function<void(std::span<float>)> sum = [](std::span<float>) {};
  /// A text of rank 0. Collective.
  std::function<std::string(const std::string&)> share = [](const std::string& text) {
    return text;
  };
  /// All throw where one has an error. Collective.
  std::function<void(const std::exception_ptr&)> agree = [](const std::exception_ptr& error) {
    if (error) std::rethrow_exception(error);
  };
};

/// What came of training.
struct Trained {
  std::vector<learning::Epoch> epochs;
  std::int64_t best = 0;        ///< the epoch whose weights are kept
  bool interrupted = false;     ///< before its end; the checkpoint goes on from the last epoch
  std::int64_t resumed = 0;     ///< epochs that an earlier run made
  std::int64_t parameters = 0;  ///< numbers that were learnt
  std::size_t silent = 0;       ///< samples for training in which nothing sounds
  double seconds = 0;           ///< of what learns in no epochs
  std::vector<std::string> remarks;
};

/// What training tells and asks on its way; each may be empty.
struct LearningWatch {
  std::function<void(const learning::Epoch&)> epoch;  ///< one ended
  std::function<void(double done, double of, const learning::Epoch& last)>
      step;                    ///< samples of this epoch
  std::function<bool()> stop;  ///< on any rank: all stop after the step
};

/// Where a training keeps what it has reached; written by rank 0 after each epoch.
struct Checkpoint {
  std::filesystem::path file;  ///< empty: nothing is kept
  std::string inputs;          ///< hash of all that decides the result; another is not gone on from
};

/// A classifier that learns, and answers afterwards. The same seed, samples and number of ranks
/// give the same bits; another number of ranks sums in another order and draws other dropout.
class Learner {
 public:
  /// @param classes  names, in the order of labels
  /// @throws InputError  an extent is too small for a branch; the method's device is not there
  Learner(const learning::Method& method, const std::vector<learning::ModalityExtent>& extents,
          const std::vector<std::string>& classes);
  ~Learner();
  Learner(Learner&&) noexcept;

  /// Trains from the checkpoint, or anew where there is none, it is damaged, or of other inputs.
  /// Adam (Kingma and Ba 2015) on the cross-entropy; the mean gradient of all ranks' samples comes
  /// from one sum a step. Linear support vector machines come from liblinear (Fan et al. 2008), in
  /// no epochs and without a checkpoint.
  /// @throws InputError  a sample that is not finite; a loss that is not, with the remedy
  /// @note Collective on the ranks.
  Trained train(learning::SampleSource& source, const learning::LabelledSamples& samples,
                const LearningRanks& ranks, const Checkpoint& checkpoint,
                const LearningWatch& watch);

  /// Logits, rows x classes.
  /// @note Collective on the ranks.
  std::vector<float> predict(learning::SampleSource& source,
                             const learning::LabelledSamples& samples,
                             const std::vector<std::uint32_t>& rows, const LearningRanks& ranks);
  /// Logits of one sample.
  /// @param modalities  values of each of the method's modalities, prepared
  std::vector<float> logits_of(const std::vector<std::vector<float>>& modalities) const;

  /// The input of values from 0 to 1 and a given mean square that a class's logit is largest for
  /// (activation maximisation, Simonyan et al. 2014, section 2; Sterling 2019, Fig. 6.9): gradient
  /// ascent, each step a twentieth of the input's length, kept to the mean square. Of a network
  /// with one modality.
  /// @param start        e.g. the samples' mean; even values may excite nothing that could rise
  /// @param mean_square  e.g. that of the samples; 0 to 1
  /// @throws InputError  several modalities, another extent, a start of zeros, or a mean square out
  /// of
  ///                     range
  std::vector<float> exciting_input(std::size_t class_number, std::span<const float> start,
                                    double mean_square) const;

  /// What the filters of a spectrogram's first convolution make of a sound, before the maximum.
  struct Activations {
    std::size_t filters = 0, bands = 0, frames = 0;  ///< where the kernel fits
    std::vector<float> values;                       ///< filters x bands x frames, 0 or more
  };
  /// @param spectrogram  prepared
  /// @throws InputError  the network does not begin with such a convolution, or has another extent
  Activations first_activations(const std::vector<float>& spectrogram) const;

  /// What is kept of a trained classifier.
  void save(const std::filesystem::path& path) const;
  /// The same for other programs: model.safetensors with weights and a table of layers, model.pt as
  /// TorchScript.
  void save_for_others(const std::filesystem::path& folder) const;
  /// @throws FileError, InputError  no such file, or damaged
  static Learner load(const std::filesystem::path& path,
                      learning::Device device = learning::Device::automatic);

  /// What it is computed on: cpu or cuda.
  std::string device() const;
  const learning::Method& method() const;
  const std::vector<std::string>& classes() const;

  struct State;  ///< torch's; for the files of this folder that know it

 private:
  std::unique_ptr<State> state_;
};

/// For main(), before anything else of torch: its first call would take all cores otherwise. Memory
/// that was freed is kept: tensors of a step are as large as those of the last, and to have the
/// system map and clear each anew takes longer than what is computed in it.
void set_up_learning(int threads);

}  // namespace carillon::eval::networks
