#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace carillon::report::service {

struct HttpRequest {
  std::string path;                           ///< as it came, without its query
  std::map<std::string, std::string> query;   ///< of names that stand twice the first
  std::map<std::string, std::string> header;  ///< by names in lower case, likewise
  std::string body;
  std::map<std::string, std::string> files;  ///< of a form, by the names of its fields
};

/// Events for a page that listens (WHATWG HTML, server-sent events): the next one's text, or
/// nothing where there is none yet; asked for once a second.
using NextEvent = std::function<std::optional<std::string>()>;

struct HttpReply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  NextEvent events{};  ///< in place of the body, until the client goes away
};

/// {"error": {"message", "hint"}}
HttpReply error_reply(int status, const std::string& message, const std::string& hint = "");

HttpReply json_reply(const nlohmann::ordered_json& document, int status = 200);

/// What `make` replies. What it throws is told as JSON, in the words of a query for those of the
/// command line: of an InputError or ConfigError the message and hint with status 400, of a
/// FileError with 404, of a StorageError with 507, of others 500.
HttpReply guarded(const std::string& path, const std::function<HttpReply()>& make);

}  // namespace carillon::report::service
