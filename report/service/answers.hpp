#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/service/http_message.hpp"
#include "report/service/strike_answer.hpp"

namespace carillon::report::service {

/// What trained networks say of a clip, as `carillon identify --json` tells it of one.
using Identify = std::function<nlohmann::ordered_json(const std::filesystem::path& clip)>;

struct AnswerOptions {
  std::vector<std::string> folders;  ///< as `carillon report` takes them; may be none
  double longest_clip = 60;          ///< [s]
  nlohmann::ordered_json made;       ///< mpi::made_by()
  Identify identify;                 ///< empty: there are no networks
  StrikeShape strike_shape;
};

/// What is computed for requests (docs/service.md): one at a time, as OpenBLAS for single threads,
/// which a rank wants, gives wrong numbers when several threads call it.
class Answers {
 public:
  explicit Answers(AnswerOptions options)
      : options_(std::move(options)), strike_(options_.folders, options_.strike_shape) {}

  bool identifies() const { return static_cast<bool>(options_.identify); }
  /// Throws nothing: see guarded().
  HttpReply answer(const HttpRequest& request);

 private:
  HttpReply made(const HttpRequest& request);

  AnswerOptions options_;
  StrikeAnswer strike_;
};

/// Answers requests on descriptors (detail/frames.hpp) until no more come. The first frame is a
/// reply of its own: {"ready": true, "identify"}.
void answer_requests(Answers& answers, int input, int output);

}  // namespace carillon::report::service
