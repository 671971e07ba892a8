#include "report/service/service.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/crypto.h>

#include <map>
#include <mutex>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "core/temporary_folder.hpp"
#include "core/trace.hpp"
#include "dataset/run/status.hpp"
#include "report/report.hpp"
#include "report/service/detail/gate.hpp"
#include "report/service/detail/newest.hpp"
#include "report/service/detail/sound_answers.hpp"

namespace carillon::report::service {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// A running build's page is made anew after so long [s].
constexpr double page_seconds = 10;

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

/// A page of another's, opened in a browser here, may have had its name changed to this machine's
/// address (DNS rebinding): then the request names that page's host.
bool asks_this_machine(const HttpRequest& request) {
  const auto at = request.header.find("host");
  if (at == request.header.end()) return true;  // no browser
  const std::string& host = at->second;
  if (host.starts_with("[")) return is_loopback(host.substr(1, host.find(']') - 1));
  return is_loopback(host.substr(0, host.find(':')));
}

HttpReply json_reply(const ordered_json& document) {
  return {200, "application/json", document.dump(1) + "\n", {}};
}

/// The same time for every wrong one.
bool are_equal(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

/// When the files last changed that a page is made of.
std::string state_of(const ReportFolders& found) {
  std::string state;
  const auto add = [&](const fs::path& path) {
    std::error_code missing;
    const auto time = fs::last_write_time(path, missing);
    if (!missing) state += fmt::format("{} {}\n", path.string(), time.time_since_epoch().count());
  };
  for (const auto& folder : found.datasets) {
    for (const char* name : {"status.json", "index.h5", "dataset.json"}) add(folder / name);
  }
  for (const auto& folder : found.studies) add(folder / "accuracy.json");
  for (const auto& folder : found.evaluations) add(folder);
  for (const auto& folder : found.nightly_runs) add(folder / "nightly.json");
  return state;
}

}  // namespace

struct Service::State {
  explicit State(ServiceOptions given)
      : options(std::move(given)), server(options.http), gate(1, options.waiting) {}

  static HttpReply busy() {
    return error_reply(503, "too many requests wait already", "try again later");
  }

  /// What a computation replies, once it may run.
  template <class Make>
  HttpReply compute(const Make& make) {
    const Gate::Pass pass = gate.enter();
    if (!pass) return busy();
    const double start = core::monotonic_seconds();
    ordered_json document = make();
    document["timing"]["service_s"] = core::monotonic_seconds() - start;
    return json_reply(document);
  }

  std::optional<HttpReply> check(const HttpRequest& request) const {
    if (options.token.empty() && !asks_this_machine(request)) {
      return error_reply(403, "this machine is asked for by another's name",
                         "http://127.0.0.1 or localhost");
    }
    if (options.token.empty() || request.path == "/v1/health") return std::nullopt;
    const auto given = request.header.find("authorization");
    const auto asked = request.query.find("token");
    const std::string word = given != request.header.end()  ? given->second
                             : asked != request.query.end() ? "Bearer " + asked->second
                                                            : "";
    if (are_equal(word, "Bearer " + options.token)) return std::nullopt;
    return error_reply(401, "a token is asked for", "Authorization: Bearer TOKEN");
  }

  HttpReply page() {
    const std::lock_guard lock(storage);
    ReportFolders found = find_report_folders(options.folders);
    std::string state = state_of(found);
    const double now = core::monotonic_seconds();
    if (page_html.empty() ||
        (state != page_state && (now - page_made > page_seconds || !is_building(found.builds)))) {
      // Modes are computed with, too.
      const Gate::Pass pass = gate.enter();
      if (!pass) return busy();
      PageRequest request;
      request.folders = options.folders;
      request.made = options.made;
      page_html = make_page(request).html;
      page_state = std::move(state);
      page_made = now;
    }
    return {200, "text/html; charset=utf-8", page_html, {}};
  }

  HttpReply datasets() {
    const std::lock_guard lock(storage);
    ordered_json list = ordered_json::array();
    for (const fs::path& folder : find_report_folders(options.folders).datasets) {
      ordered_json entry = {{"folder", folder.string()}};
      try {
        const ordered_json status = dataset::run::read_status(folder);
        for (const char* key : {"name", "state", "fraction", "samples", "objects"}) {
          if (status.contains(key)) entry[key] = status[key];
        }
      } catch (const core::Error& error) {
        entry["state"] = error.message();
      }
      list.push_back(std::move(entry));
    }
    return json_reply({{"datasets", list}});
  }

  HttpReply health() const {
    return json_reply({{"ready", true},
                       {"carillon", options.made.value("carillon", "")},
                       {"identify", static_cast<bool>(options.identify)}});
  }

  /// Every build's status; of one that cannot be read why, as folders may go while they are served.
  ordered_json builds() const {
    ordered_json found = ordered_json::array();
    for (const fs::path& folder : find_report_folders(options.folders).builds) {
      try {
        ordered_json status = dataset::run::read_status(folder);
        status["folder"] = folder.string();
        status["line"] = dataset::run::status_line(status);
        found.push_back(std::move(status));
      } catch (const core::Error&) {
        // It was deleted just now.
      }
    }
    return found;
  }

  /// What all pages that listen are told; looked for once a second.
  std::string news() {
    const std::lock_guard lock(newsroom);
    const double now = core::monotonic_seconds();
    if (!latest.empty() && now - latest_made < 1) return latest;
    try {
      latest = ordered_json{{"builds", builds()}}.dump();
    } catch (const std::exception& error) {
      latest = ordered_json{{"builds", nullptr}, {"error", error.what()}}.dump();
    }
    latest_made = now;
    return latest;
  }

  void route() {
    server.guard([this](const HttpRequest& request) { return check(request); });
    server.get("/", [this](const HttpRequest&) { return page(); });
    server.get("/v1/health", [this](const HttpRequest&) { return health(); });
    server.get("/v1/datasets", [this](const HttpRequest&) { return datasets(); });
    server.get("/v1/newest", [this](const HttpRequest& request) {
      const std::lock_guard lock(storage);
      return newest_reply(request, options.folders);
    });
    server.get("/v1/events", [this](const HttpRequest&) {
      const auto next = [this, told = std::string()]() mutable -> std::optional<std::string> {
        std::string latest_news = news();
        if (latest_news == told) return std::nullopt;
        return told = std::move(latest_news);
      };
      return HttpReply{200, "", "", next};
    });
    const auto answers = [&](const char* path,
                             ordered_json (*answer)(const HttpRequest&, const ClipLimits&)) {
      server.post(path, [this, answer](const HttpRequest& request) {
        return compute([&] { return answer(request, {options.longest_clip}); });
      });
    };
    answers("/v1/features", features_of);
    answers("/v1/fit", fit_of);
    answers("/v1/compare", comparison_of);
    server.post("/v1/identify", [this](const HttpRequest& request) {
      if (!options.identify) {
        return error_reply(501, "there are no trained networks here",
                           "carillon serve FOLDER --models MODELS");
      }
      return compute([&] { return identified(request, {options.longest_clip}, options.identify); });
    });
  }

  ServiceOptions options;
  HttpServer server;
  Gate gate;
  /// HDF5 is asked by one thread at a time.
  std::mutex storage;
  std::mutex newsroom;
  std::string latest;
  double latest_made = 0;
  std::string page_html, page_state;
  double page_made = 0;
  int port = 0;
};

Service::Service(ServiceOptions options) : state_(std::make_unique<State>(std::move(options))) {
  const ServiceOptions& own = state_->options;
  if (own.token.empty() && !is_loopback(own.host)) {
    throw core::InputError(
        fmt::format("{} can be reached from other machines, and no token is asked for", own.host),
        "--token FILE names a file with one, or leave --host at 127.0.0.1");
  }
  find_report_folders(own.folders);
  state_->route();
  state_->port = state_->server.bind(own.host, own.port);
}

Service::~Service() = default;

int Service::port() const {
  return state_->port;
}

void Service::run() {
  state_->server.listen();
}

void Service::stop() {
  state_->server.stop();
}

}  // namespace carillon::report::service
