// Layers: extents, gradients against finite differences, and fusions against their formulas.
#include <gtest/gtest.h>
#include <torch/script.h>

#include <cmath>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "eval/networks/detail/layer_table.hpp"
#include "eval/networks/detail/networks.hpp"
#include "eval/networks/detail/portable_weights.hpp"
#include "eval/networks/detail/weights.hpp"
#include "tests/eval/learning/made_source.hpp"

namespace carillon::eval {
namespace {

/// Extents of real data, except of voxels, which are fewer.
learning::ModalityExtent extent_of(learning::Modality modality) {
  switch (modality) {
    case learning::Modality::spectrogram:
      return {1, 64, 25};
    case learning::Modality::waveform:
      return {1, 22050};
    case learning::Modality::voxels:
      return {1, 12, 12, 12};
    case learning::Modality::image:
      return {3, 64, 64};
    case learning::Modality::touch:
      return {3, 400};
  }
  return {};
}

std::vector<learning::ModalityExtent> extents_of(const learning::Method& method) {
  std::vector<learning::ModalityExtent> extents;
  for (const learning::Modality modality : method.modalities)
    extents.push_back(extent_of(modality));
  return extents;
}

std::vector<torch::Tensor> random_modalities(const learning::Method& method, std::int64_t samples) {
  std::vector<torch::Tensor> modalities;
  for (learning::ModalityExtent extent : extents_of(method)) {
    extent.insert(extent.begin(), samples);
    modalities.push_back(torch::randn(extent));
  }
  return modalities;
}

class Branches : public testing::TestWithParam<learning::Branch> {};

TEST_P(Branches, GiveFeaturesAndLogitsAndEveryWeightLearns) {
  torch::manual_seed(1);
  const learning::Method method = made_method({GetParam()});
  const auto network = networks::make_classifier(method, extents_of(method), 5);
  const auto modalities = random_modalities(method, 4);
  network->train();
  EXPECT_EQ(network->features(modalities).sizes(), (std::vector<std::int64_t>{4, 16}));
  const torch::Tensor logits = network->forward(modalities);
  EXPECT_EQ(logits.sizes(), (std::vector<std::int64_t>{4, 5}));
  logits.square().sum().backward();
  for (const auto& item : network->named_parameters()) {
    EXPECT_TRUE(item.value().grad().defined()) << item.key();
    EXPECT_TRUE(torch::isfinite(item.value().grad()).all().item<bool>()) << item.key();
  }
}
TEST_P(Branches, AreDescribedByTheirLayers) {
  // The TorchScript of the table, which has no other source, answers as the network does.
  torch::manual_seed(7);
  const learning::Method method = made_method({GetParam(), GetParam()}, learning::Fusion::bilinear);
  const auto network = networks::make_classifier(method, extents_of(method), 5);
  const auto modalities = random_modalities(method, 4);
  network->train();
  network->forward(modalities);  // statistics that are not those of nothing
  network->eval();
  const core::TemporaryFolder folder;
  const auto table =
      networks::layer_table(*network, method, extents_of(method), {"a", "b", "c", "d", "e"});
  networks::write_torch_script(folder.path() / "model.pt", table, networks::weights_of(*network));
  torch::jit::Module script = torch::jit::load((folder.path() / "model.pt").string());
  const torch::Tensor found = script.forward({modalities[0], modalities[1]}).toTensor();
  EXPECT_LT((found - network->forward(modalities)).abs().max().item<double>(), 1e-5);
}

TEST(Copies, AreDescribedByTheirLayers) {
  torch::manual_seed(8);
  const learning::Method method =
      made_method({learning::Branch::voxnet, learning::Branch::image}, learning::Fusion::add);
  const std::vector<learning::ModalityExtent> extents = {{4, 12, 12, 12}, {3, 3, 64, 64}};
  const auto network = networks::make_classifier(method, extents, 5);
  network->eval();
  const core::TemporaryFolder folder;
  const auto table = networks::layer_table(*network, method, extents, {"a", "b", "c", "d", "e"});
  networks::write_torch_script(folder.path() / "model.pt", table, networks::weights_of(*network));
  torch::jit::Module script = torch::jit::load((folder.path() / "model.pt").string());
  const torch::Tensor voxels = torch::randn({2, 4, 12, 12, 12});
  const torch::Tensor views = torch::randn({2, 3, 3, 64, 64});
  const torch::Tensor found = script.forward({voxels, views}).toTensor();
  EXPECT_LT((found - network->forward({voxels, views})).abs().max().item<double>(), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(All, Branches, testing::ValuesIn(learning::all_branches),
                         [](const auto& name) {
                           return std::string(learning::name_of(name.param));
                         });

TEST(Isnn, HasAsManyConvolutionsAsAreAskedFor) {
  learning::Method method = made_method({learning::Branch::isnn});
  method.sizes.layers = {{.filters = 16, .kernel_bands = 16, .kernel_frames = 4},
                         {.filters = 32, .kernel_bands = 3, .kernel_frames = 3}};
  // 64 x 25: (64 - 15) / 2 = 24 x 11, then (24 - 2) / 2 = 11 x 4.
  const std::int64_t expected =
      (16 * 16 * 4 + 16) + (32 * 16 * 3 * 3 + 32) + (32 * 11 * 4 * 16 + 16) + (16 * 5 + 5);
  EXPECT_EQ(networks::parameter_count(*networks::make_classifier(method, extents_of(method), 5)),
            expected);
  method.sizes.layers[1].kernel_bands = 25;  // of 24
  try {
    networks::make_classifier(method, extents_of(method), 5);
    FAIL() << "built";
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("convolution 2 of isnn needs at least 26 bands"),
              std::string::npos)
        << error.what();
  }
}

TEST(TurnedCopies, VoteByTheMeanOfTheirLogits) {
  torch::manual_seed(3);
  const learning::Method method = made_method({learning::Branch::voxnet});
  const auto network = networks::make_classifier(method, {{4, 12, 12, 12}}, 5);
  const torch::Tensor copies = torch::randn({6, 4, 12, 12, 12});
  network->eval();
  torch::Tensor mean = torch::zeros({6, 5});
  for (std::int64_t k = 0; k < 4; ++k) {
    mean += network->forward({copies.slice(1, k, k + 1).expand({6, 4, 12, 12, 12})}) / 4;
  }
  EXPECT_TRUE(torch::allclose(network->forward({copies}), mean, 1e-4, 1e-6));
  // One of them while it learns: samples that are alike but for the copies differ by more than
  // drop-out alone makes copies that are alike differ.
  network->train();
  EXPECT_EQ(network->forward({copies}).sizes(), (std::vector<std::int64_t>{6, 5}));
  const torch::Tensor empty = torch::zeros({6, 1, 12, 12, 12});
  torch::Tensor marked = torch::cat({empty, empty + 30, empty + 60, empty + 90}, 1);
  torch::Tensor met = network->forward({marked.repeat({20, 1, 1, 1, 1})}).norm(2, 1);
  EXPECT_GT(met.max().item<float>(), 2 * met.min().item<float>());
}

TEST(Branches, SayWhatTheyNeedWhereASenseIsTooSmall) {
  EXPECT_THROW(networks::make_classifier(made_method({learning::Branch::isnn}), {{1, 4, 25}}, 3),
               core::InputError);
  EXPECT_THROW(
      networks::make_classifier(made_method({learning::Branch::voxnet}), {{1, 8, 8, 8}}, 3),
      core::InputError);
  EXPECT_THROW(
      networks::make_classifier(made_method({learning::Branch::soundnet5}), {{1, 3549}}, 3),
      core::InputError);
  EXPECT_THROW(
      networks::make_classifier(made_method({learning::Branch::soundnet8}), {{1, 4573}}, 3),
      core::InputError);
  EXPECT_THROW(networks::make_classifier(made_method({learning::Branch::touch}), {{3, 20}}, 3),
               core::InputError);
}

TEST(Soundnets, LearnFromOneSampleOfTheShortestClips) {
  for (const auto& [branch, samples] :
       {std::pair{learning::Branch::soundnet5, 3550}, std::pair{learning::Branch::soundnet8, 4574},
        std::pair{learning::Branch::soundnet8, 11025}}) {
    torch::manual_seed(4);
    const auto network = networks::make_classifier(made_method({branch}), {{1, samples}}, 3);
    network->train();
    const torch::Tensor logits = network->forward({torch::randn({1, 1, samples})});
    EXPECT_TRUE(torch::isfinite(logits).all().item<bool>()) << learning::name_of(branch) << samples;
    logits.square().sum().backward();
  }
}

TEST(Soundnet8, HasThePapersWeights) {
  // Aytar et al. 2016: convolutions of 64, 32, 16, 8, 4, 4, 4 samples, and two numbers of each
  // normalised channel, whose shift is the convolution's bias too.
  const std::int64_t channels[] = {1, 16, 32, 64, 128, 256, 512, 1024};
  const std::int64_t kernels[] = {64, 32, 16, 8, 4, 4, 4};
  std::int64_t expected = 0;
  for (int i = 0; i < 7; ++i)
    expected += channels[i] * channels[i + 1] * kernels[i] + 2 * channels[i + 1];
  expected += 1024 * 16 + 16 + 16 * 5 + 5;  // this network's dense layers
  const learning::Method method = made_method({learning::Branch::soundnet8});
  EXPECT_EQ(networks::parameter_count(*networks::make_classifier(method, extents_of(method), 5)),
            expected);
}

TEST(Networks, ImageTakesTheLargestOfEachFeatureOverTheViews) {
  torch::manual_seed(6);
  const learning::Method method = made_method({learning::Branch::image});
  const auto several = networks::make_classifier(method, {{3, 3, 64, 64}}, 4);
  const auto single = networks::make_classifier(method, {{3, 64, 64}}, 4);
  const torch::NoGradGuard no_gradient;
  ASSERT_EQ(networks::parameter_count(*several), networks::parameter_count(*single))
      << "the convolutions are shared";
  const auto own = single->parameters(), theirs = several->parameters();
  for (std::size_t i = 0; i < own.size(); ++i) own[i].data().copy_(theirs[i]);
  several->eval();
  single->eval();
  const torch::Tensor view = torch::randn({2, 3, 64, 64});
  const torch::Tensor same = torch::stack({view, view, view}, 1);
  EXPECT_TRUE(torch::allclose(several->forward({same}), single->forward({view}), 1e-4, 1e-5));
  const torch::Tensor views = torch::randn({2, 3, 3, 64, 64});
  const torch::Tensor turned = views.index_select(1, torch::tensor({2, 0, 1}));
  EXPECT_TRUE(torch::allclose(several->forward({views}), several->forward({turned}), 1e-4, 1e-5));
  EXPECT_FALSE(torch::allclose(several->forward({views}), several->forward({same})));
}

class Fusions : public testing::TestWithParam<learning::Fusion> {};

TEST_P(Fusions, HaveTheGradientOfFiniteDifferences) {
  torch::manual_seed(2);
  learning::Method method = made_method(
      {learning::Branch::isnn, learning::Branch::touch, learning::Branch::image}, GetParam());
  method.sizes.dropout = 0;
  const auto network = networks::make_classifier(method, extents_of(method), 3);
  network->to(torch::kFloat64);
  network->eval();  // no dropout
  auto modalities = random_modalities(method, 2);
  for (torch::Tensor& modality : modalities) modality = modality.to(torch::kFloat64);
  const auto loss = [&] {
    return torch::nn::functional::cross_entropy(network->forward(modalities),
                                                torch::tensor({0, 2}, torch::kInt64));
  };
  loss().backward();
  for (const auto& item : network->named_parameters()) {
    torch::Tensor weights = item.value();
    const torch::Tensor gradient = weights.grad().flatten();
    torch::Tensor flat = weights.data().view(-1);
    const std::int64_t at = gradient.abs().argmax().item<std::int64_t>();
    const double before = flat[at].item<double>(), step = 1e-6;
    const torch::NoGradGuard no_gradient;
    flat[at] = before + step;
    const double above = loss().item<double>();
    flat[at] = before - step;
    const double below = loss().item<double>();
    flat[at] = before;
    EXPECT_NEAR((above - below) / (2 * step), gradient[at].item<double>(),
                1e-7 + 1e-4 * std::abs(gradient[at].item<double>()))
        << item.key();
  }
}

TEST_P(Fusions, TakeAnyNumberOfBranches) {
  const learning::Method method = made_method({learning::Branch::isnn, learning::Branch::voxnet,
                                               learning::Branch::touch, learning::Branch::image},
                                              GetParam());
  const auto network = networks::make_classifier(method, extents_of(method), 3);
  EXPECT_EQ(network->forward(random_modalities(method, 2)).size(1), 3);
}
INSTANTIATE_TEST_SUITE_P(All, Fusions, testing::ValuesIn(learning::all_fusions),
                         [](const auto& name) {
                           return std::string(learning::name_of(name.param));
                         });

/// Features of the branches of a network alone, by networks of one branch with the same weights.
std::vector<torch::Tensor> branch_features(const networks::Classifier& fused,
                                           const learning::Method& method,
                                           const std::vector<torch::Tensor>& modalities) {
  std::vector<torch::Tensor> features;
  for (std::size_t b = 0; b < method.branches.size(); ++b) {
    const learning::Method alone = made_method({method.branches[b]});
    const auto network = networks::make_classifier(alone, extents_of(alone), 3);
    network->eval();
    const torch::NoGradGuard no_gradient;
    const std::string prefix = "branch" + std::to_string(b) + ".";
    auto weights = network->named_parameters();
    for (const auto& item : fused.named_parameters()) {
      if (item.key().starts_with(prefix)) {
        weights["branch0." + item.key().substr(prefix.size())].copy_(item.value());
      }
    }
    features.push_back(network->features({modalities[b]}));
  }
  return features;
}

class FusionFormulas : public testing::TestWithParam<learning::Fusion> {};

TEST_P(FusionFormulas, AreThoseOfThePapers) {
  torch::manual_seed(3);
  const learning::Method method =
      made_method({learning::Branch::isnn, learning::Branch::voxnet}, GetParam());
  const auto network = networks::make_classifier(method, extents_of(method), 3);
  network->eval();
  const auto modalities = random_modalities(method, 4);
  const auto features = branch_features(*network, method, modalities);
  const auto weights = network->named_parameters();
  const auto project = [&](std::size_t b) {
    const std::string layer = "product.projection" + std::to_string(b);
    return features[b].matmul(weights[layer + ".weight"].t()) + weights[layer + ".bias"];
  };
  torch::Tensor expected;
  switch (GetParam()) {
    case learning::Fusion::concatenate:
      expected = torch::cat(features, 1);
      break;
    case learning::Fusion::add:
      expected = features[0] + features[1];
      break;
    case learning::Fusion::multiply:
      expected = torch::tanh(project(0)) * torch::tanh(project(1));
      break;
    case learning::Fusion::bilinear: {
      // Sum over groups of 3, signed root, unit length: written out.
      const torch::Tensor product = (project(0) * project(1)).contiguous();
      expected = torch::zeros({4, 12});
      for (int n = 0; n < 4; ++n) {
        double square = 0;
        for (int o = 0; o < 12; ++o) {
          double sum = 0;
          for (int k = 0; k < 3; ++k) sum += product[n][3 * o + k].item<double>();
          expected[n][o] = std::copysign(std::sqrt(std::abs(sum)), sum);
          square += std::abs(sum);
        }
        for (int o = 0; o < 12; ++o) expected[n][o] = expected[n][o] / std::sqrt(square);
      }
    }
  }
  EXPECT_LT((network->features(modalities) - expected).abs().max().item<double>(), 1e-5);
}
INSTANTIATE_TEST_SUITE_P(All, FusionFormulas, testing::ValuesIn(learning::all_fusions),
                         [](const auto& name) {
                           return std::string(learning::name_of(name.param));
                         });

TEST(Bilinear, HasAFiniteGradientWhereNothingIsFelt) {
  learning::Method method =
      made_method({learning::Branch::isnn, learning::Branch::voxnet}, learning::Fusion::bilinear);
  const auto network = networks::make_classifier(method, extents_of(method), 3);
  {
    const torch::NoGradGuard no_gradient;
    for (torch::Tensor& weight : network->parameters()) weight.zero_();
  }
  network->forward(random_modalities(method, 2)).sum().backward();
  for (const torch::Tensor& weight : network->parameters()) {
    EXPECT_TRUE(torch::isfinite(weight.grad()).all().item<bool>());
  }
}

TEST(Weights, ComeBackAndGradientsGoRoundUnchanged) {
  torch::manual_seed(4);
  const learning::Method method = made_method({learning::Branch::soundnet5});
  const auto first = networks::make_classifier(method, extents_of(method), 3);
  const auto second = networks::make_classifier(method, extents_of(method), 3);
  const auto modalities = random_modalities(method, 3);
  first->train();
  first->forward(modalities).square().sum().backward();
  networks::from_bytes(networks::to_bytes(*first), *second);
  first->eval();
  second->eval();
  EXPECT_TRUE(first->forward(modalities).equal(second->forward(modalities)));
  // Gradients as one row: torch adds to it in place.
  torch::Tensor flat = torch::zeros({networks::parameter_count(*second)});
  networks::bind_gradients(*second, flat);
  second->train();
  second->forward(modalities).square().sum().backward();
  std::int64_t at = 0;
  for (const torch::Tensor& parameter : second->parameters()) {
    const torch::Tensor own = flat.slice(0, at, at + parameter.numel()).view_as(parameter);
    EXPECT_TRUE(own.equal(parameter.grad()));
    EXPECT_EQ(own.data_ptr<float>(), parameter.grad().data_ptr<float>());
    at += parameter.numel();
  }
  EXPECT_GT(flat.abs().max().item<float>(), 0);
  auto statistics = networks::running_statistics(*first);
  EXPECT_EQ(statistics.size(), 2u * (32 + 64 + 128 + 256));
  networks::set_running_statistics(statistics, *second);
  EXPECT_EQ(networks::running_statistics(*second), statistics);
}

}  // namespace
}  // namespace carillon::eval
