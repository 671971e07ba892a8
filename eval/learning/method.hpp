#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/learning/modality.hpp"

namespace carillon::eval::learning {

/// Part of a network that turns one modality into features.
enum class Branch {
  isnn,  ///< spectrogram: a convolution with a tall kernel, or several, one dense layer (Sterling
         ///< 2019, 6.3.2)
  soundnet5,  ///< waveform (Aytar et al. 2016), trained from scratch
  soundnet8,
  voxnet,  ///< voxels (Maturana and Scherer 2015)
  image,   ///< three small convolutions
  touch    ///< three small convolutions over time
};

/// How the branches' features become one vector (Sterling 2019, 6.3.2.2).
enum class Fusion {
  concatenate,
  add,
  multiply,  ///< element-wise product of projections (Park et al. 2016)
  bilinear   ///< multimodal factorised bilinear pooling (Yu et al. 2017)
};

enum class MethodKind { network, nearest_neighbour, linear_svm };

/// One convolution of ISNN and the maximum behind it.
struct SpectrogramLayer {
  std::int64_t filters = 32;
  std::int64_t kernel_bands = 32, kernel_frames = 4;
  std::int64_t pool_bands = 2, pool_frames = 2;  ///< the maximum's window
};

/// Layer sizes that the papers do not give.
struct LayerSizes {
  std::int64_t width = 128;                 ///< of each branch's first dense layer
  std::vector<SpectrogramLayer> layers{1};  ///< of ISNN, one in the papers
  double dropout = 0.3;                     ///< before and after ISNN's dense layer
  std::int64_t fused = 256;                 ///< outputs of bilinear pooling
  std::int64_t factors = 5;                 ///< products that each of these sums
};

/// What a network is computed on.
enum class Device {
  automatic,  ///< a graphics card where libtorch finds one, else the processor
  cpu,
  cuda
};

/// How the learning rate falls.
enum class Schedule {
  plateau,  ///< to a third after each half of the patience without a better validation loss
  cosine    ///< along half a cosine over all epochs (Loshchilov and Hutter 2017, eq. 5)
};

/// How the numbers of a network are found.
struct LearningOptions {
  std::int64_t epochs = 60;     ///< at most
  std::int64_t patience = 8;    ///< epochs without a better validation loss, then a plateau ends
  std::int64_t batch = 64;      ///< samples of a step, over all ranks
  double learning_rate = 1e-3;  ///< of Adam, the first
  Schedule schedule = Schedule::plateau;
  double weight_decay = 1e-4;
  /// Weight of the loss on sounds of no class, for networks that only hear; 0: they meet none.
  double outliers = 0.5;
  double equaliser = 0;          ///< greatest gain of spectrograms' bands while it learns [dB]
  std::uint64_t seed = 0;        ///< of the first weights, the order of samples and dropout
  double memory = 2147483648.0;  ///< of a rank for samples [B]; more than fits is read every epoch
  Device device = Device::automatic;  ///< of no training's name: another gives nearly the same
};

/// A classifier and how it is trained.
struct Method {
  std::string name;
  MethodKind kind = MethodKind::network;
  std::vector<Branch> branches;  ///< of a network
  Fusion fusion = Fusion::concatenate;
  std::vector<Modality> modalities;  ///< what it perceives; of a network, those of its branches
  SpectrogramInput spectrogram;      ///< where it gets one
  LayerSizes sizes;
  LearningOptions learning;
  std::int64_t neighbours = 1;  ///< of nearest_neighbour
  double cost = 1;              ///< of linear_svm: of a sample on the wrong side
};

/// Whether it is a network that hears and perceives nothing else: it can be asked for a sound.
bool only_hears(const Method& method);

std::string_view name_of(Branch branch);
std::string_view name_of(Fusion fusion);
std::string_view name_of(MethodKind kind);
std::string_view name_of(Device device);
std::string_view name_of(Schedule schedule);
/// @throws InputError  none of `auto`, `cpu` and `cuda`
Device device_named(const std::string& name);
Modality modality_of(Branch branch);

inline constexpr Branch all_branches[] = {Branch::isnn,   Branch::soundnet5, Branch::soundnet8,
                                          Branch::voxnet, Branch::image,     Branch::touch};
inline constexpr Fusion all_fusions[] = {Fusion::concatenate, Fusion::add, Fusion::multiply,
                                         Fusion::bilinear};
inline constexpr Device all_devices[] = {Device::automatic, Device::cpu, Device::cuda};
inline constexpr Schedule all_schedules[] = {Schedule::plateau, Schedule::cosine};
inline constexpr MethodKind all_method_kinds[] = {
    MethodKind::network, MethodKind::nearest_neighbour, MethodKind::linear_svm};

/// Everything that decides a trained classifier's numbers, beside its samples.
nlohmann::ordered_json to_json(const Method& method);
/// @throws InputError  a name that this version does not know
Method method_from(const nlohmann::json& json);

}  // namespace carillon::eval::learning
