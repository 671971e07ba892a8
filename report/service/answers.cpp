#include "report/service/answers.hpp"

#include "core/error.hpp"
#include "core/trace.hpp"
#include "report/report.hpp"
#include "report/service/detail/frames.hpp"
#include "report/service/detail/newest.hpp"
#include "report/service/detail/sound_answers.hpp"

namespace carillon::report::service {

using nlohmann::ordered_json;

HttpReply Answers::made(const HttpRequest& request) {
  const double start = core::monotonic_seconds();
  const ClipLimits limits{options_.longest_clip};
  const auto timed = [&](ordered_json document) {
    document["timing"]["service_s"] = core::monotonic_seconds() - start;
    return json_reply(document);
  };
  if (request.path == "/v1/features") return timed(features_of(request, limits));
  if (request.path == "/v1/fit") return timed(fit_of(request, limits));
  if (request.path == "/v1/compare") return timed(comparison_of(request, limits));
  if (request.path == "/v1/identify") {
    if (!options_.identify) {
      return error_reply(501, "there are no trained networks here",
                         "carillon serve FOLDER --models MODELS");
    }
    return timed(identified(request, limits, options_.identify));
  }
  if (request.path == "/v1/newest") return newest_reply(request, options_.folders);
  if (request.path == "/v1/strike") return strike_(request);
  if (request.path == "/") {
    PageRequest page;
    page.folders = options_.folders;
    page.made = options_.made;
    page.may_be_empty = true;
    if (const auto command = request.query.find("made_by"); command != request.query.end()) {
      page.made["command"] = command->second;
    }
    return {200, "text/html; charset=utf-8", make_page(page).html, {}};
  }
  return error_reply(404, request.path + ": there is no such page");
}

HttpReply Answers::answer(const HttpRequest& request) {
  return guarded(request.path, [&] { return made(request); });
}

void answer_requests(Answers& answers, int input, int output) {
  Frames frames(input, output);
  frames.send(json_reply({{"ready", true}, {"identify", answers.identifies()}}));
  while (!frames.broken()) {
    std::optional<HttpRequest> request;
    try {
      request = frames.next_request();
    } catch (const core::InputError& error) {
      // What follows cannot be told from its bytes.
      frames.send(error_reply(400, error.message(), error.hint()));
      return;
    }
    if (!request) return;
    frames.send(answers.answer(*request));
  }
}

}  // namespace carillon::report::service
