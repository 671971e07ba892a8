#include "report/service/service.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/crypto.h>

#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/trace.hpp"
#include "dataset/exporters/seal.hpp"
#include "dataset/run/status.hpp"
#include "report/report.hpp"
#include "report/service/detail/newest.hpp"
#include "report/service/job_requests.hpp"
#include "report/service/jobs/job_queue.hpp"

namespace carillon::report::service {

/// The text of share/carillon/openapi.json; see carillon_embed() in cmake/CarillonService.cmake.
extern const std::string_view openapi_json;

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// A running build's page is made anew after so long [s].
constexpr double page_seconds = 10;

bool is_loopback(const std::string& host) {
  in_addr address{};
  if (inet_pton(AF_INET, host.c_str(), &address) == 1) return ntohl(address.s_addr) >> 24 == 127;
  return host == "localhost" || host == "::1";
}

/// A page of another's, opened in a browser here, may have had its name changed to this machine's
/// address (DNS rebinding): then the request names that page's host.
bool asks_this_machine(const HttpRequest& request) {
  const auto names_loopback = [&](const char* header) {
    const auto at = request.header.find(header);
    if (at == request.header.end()) return true;  // no browser
    const std::size_t scheme = at->second.find("://");
    const std::string host = at->second.substr(scheme == std::string::npos ? 0 : scheme + 3);
    if (host.starts_with("[")) return is_loopback(host.substr(1, host.find(']') - 1));
    return is_loopback(host.substr(0, host.find(':')));
  };
  // Nor may a page from elsewhere send what changes something here.
  return names_loopback("host") && names_loopback("origin");
}

/// What tells the labels that a seal hides.
bool tells_labels(const std::string& path) {
  return path == "/" || path == "/v1/newest" || path == "/v1/strike";
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
  for (const auto& folder : found.sweeps) add(folder / "sweep.json");
  for (const auto& folder : found.studies) add(folder / "accuracy.json");
  for (const auto& folder : found.evaluations) add(folder);
  for (const auto& folder : found.nightly_runs) add(folder / "nightly.json");
  return state;
}

}  // namespace

struct Service::State {
  explicit State(ServiceOptions given)
      : options(std::move(given)), server(options.http), workers(options.workers) {
    if (!options.jobs.empty()) {
      jobs.emplace(JobQueueOptions{options.jobs, options.workers.program, options.launcher,
                                   options.max_jobs});
      // What builds make is on the page.
      options.folders.push_back(options.jobs);
    }
  }

  ReportFolders found() const {
    return find_report_folders(options.folders, /*may_be_empty=*/jobs.has_value());
  }

  std::optional<HttpReply> check(const HttpRequest& request) const {
    if (options.token.empty() && !asks_this_machine(request)) {
      return error_reply(403, "this machine is asked for by another's name or page",
                         "http://127.0.0.1 or localhost");
    }
    if (!options.seals.empty() && tells_labels(request.path)) {
      return error_reply(403, "this service scores sealed answers, and this would tell the labels",
                         "serve the page by another one, without --sealed");
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

  /// The page as it was made last, or made anew; others who ask meanwhile wait for it.
  HttpReply page() {
    const std::lock_guard lock(page_making);
    const ReportFolders folders = found();
    std::string state = state_of(folders);
    const double now = core::monotonic_seconds();
    if (page_reply.body.empty() ||
        (state != page_state && (now - page_made > page_seconds || !is_building(folders.builds)))) {
      HttpRequest request{.path = "/"};
      request.query["made_by"] = options.made.value("command", "");
      HttpReply reply = workers.ask(request);
      if (reply.status != 200) return reply;
      page_reply = std::move(reply);
      page_state = std::move(state);
      page_made = now;
    }
    return page_reply;
  }

  HttpReply datasets() const {
    ordered_json list = ordered_json::array();
    for (const fs::path& folder : found().datasets) {
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
                       {"identify", workers.identifies()},
                       {"jobs", jobs.has_value()}});
  }

  /// Every build's status; of one that cannot be read why, as folders may go while they are served.
  ordered_json builds() const {
    ordered_json list = ordered_json::array();
    for (const fs::path& folder : found().builds) {
      try {
        ordered_json status = dataset::run::read_status(folder);
        status["folder"] = folder.string();
        status["line"] = dataset::run::status_line(status);
        list.push_back(std::move(status));
      } catch (const core::Error&) {
        // It was deleted just now.
      }
    }
    return list;
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

  /// The places that jobs may name, as they are now.
  JobPlaces places() const {
    return {found().datasets,
            {options.seals.begin(), options.seals.end()},
            options.ranks,
            options.cache};
  }

  HttpReply submit(const HttpRequest& request,
                   JobRequest (*read)(const HttpRequest&, const JobPlaces&)) {
    if (!jobs) return no_jobs();
    return json_reply(jobs->submit(read(request, places())), 202);
  }

  static HttpReply no_jobs() {
    return error_reply(501, "no jobs are taken here", "carillon serve FOLDER --jobs JOBS");
  }

  /// What `use` makes of the job that the path ends with.
  template <class Use>
  HttpReply with_job(const HttpRequest& request, const Use& use) {
    if (!jobs) return no_jobs();
    const std::string name = request.path.substr(request.path.rfind('/') + 1);
    const std::optional<std::int64_t> id = core::number_in<std::int64_t>(name);
    std::optional<ordered_json> document;
    if (id && *id > 0 && *id <= std::numeric_limits<int>::max()) {
      document = use(static_cast<int>(*id));
    }
    if (!document) return error_reply(404, fmt::format("there is no job {}", name));
    return json_reply(*document);
  }

  void route() {
    const auto compute = [this](const HttpRequest& request) { return workers.ask(request); };
    server.guard([this](const HttpRequest& request) { return check(request); });
    server.get("/", [this](const HttpRequest&) { return page(); });
    server.get("/v1/health", [this](const HttpRequest&) { return health(); });
    server.get("/v1/openapi.json", [](const HttpRequest&) {
      return HttpReply{200, "application/json", std::string(openapi_json), {}};
    });
    server.get("/v1/datasets", [this](const HttpRequest&) { return datasets(); });
    server.get("/v1/newest", compute);
    server.get("/v1/events", [this](const HttpRequest&) {
      const auto next = [this, told = std::string()]() mutable -> std::optional<std::string> {
        std::string latest_news = news();
        if (latest_news == told) return std::nullopt;
        return told = std::move(latest_news);
      };
      return HttpReply{200, "", "", next};
    });
    for (const char* path :
         {"/v1/features", "/v1/fit", "/v1/compare", "/v1/identify", "/v1/strike"}) {
      server.post(path, compute);
    }
    server.get("/v1/strike", compute);  // what a page may play
    server.post("/v1/score",
                [this](const HttpRequest& request) { return submit(request, score_job); });
    server.post("/v1/jobs",
                [this](const HttpRequest& request) { return submit(request, command_job); });
    server.get("/v1/jobs", [this](const HttpRequest&) {
      return jobs ? json_reply({{"jobs", jobs->all()}}) : no_jobs();
    });
    server.get(R"(/v1/jobs/\d{1,10})", [this](const HttpRequest& request) {
      return with_job(request, [this](int id) { return jobs->find(id); });
    });
    server.remove(R"(/v1/jobs/\d{1,10})", [this](const HttpRequest& request) {
      return with_job(request, [this](int id) { return jobs->cancel(id); });
    });
  }

  ServiceOptions options;
  HttpServer server;
  WorkerPool workers;
  std::optional<JobQueue> jobs;
  std::mutex newsroom;
  std::string latest;
  double latest_made = 0;
  std::mutex page_making;
  HttpReply page_reply;
  std::string page_state;
  double page_made = 0;
  int port = 0;
};

Service::Service(ServiceOptions options) {
  if (options.token.empty() && !is_loopback(options.host)) {
    throw core::InputError(
        fmt::format("{} can be reached from other machines, and no token is asked for",
                    options.host),
        "--token FILE names a file with one, or leave --host at 127.0.0.1");
  }
  find_report_folders(options.folders, /*may_be_empty=*/!options.jobs.empty());
  for (const std::string& seal : options.seals) dataset::exporters::read_seal(seal);
  state_ = std::make_unique<State>(std::move(options));
  state_->route();
  state_->port = state_->server.bind(state_->options.host, state_->options.port);
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
