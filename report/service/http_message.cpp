#include "report/service/http_message.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cctype>
#include <new>

#include "core/error.hpp"
#include "core/storage_error.hpp"

namespace carillon::report::service {

namespace {

/// Options of the command line are written in a query without dashes: `--max-features` is
/// `max_features`.
std::string in_query_words(const std::string& text) {
  std::string words;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = text.compare(i, 2, "--") == 0 && i + 2 < text.size() &&
                        std::islower(static_cast<unsigned char>(text[i + 2])) != 0 &&
                        (i == 0 || text[i - 1] == ' ');
    if (!begins) {
      words += text[i];
      continue;
    }
    for (i += 2; i < text.size() &&
                 (std::islower(static_cast<unsigned char>(text[i])) != 0 ||
                  std::isdigit(static_cast<unsigned char>(text[i])) != 0 || text[i] == '-');
         ++i) {
      words += text[i] == '-' ? '_' : text[i];
    }
    --i;
  }
  return words;
}

HttpReply told(int status, const core::Error& error) {
  return error_reply(status, in_query_words(error.message()), in_query_words(error.hint()));
}

}  // namespace

HttpReply error_reply(int status, const std::string& message, const std::string& hint) {
  nlohmann::ordered_json error = {{"message", message}};
  if (!hint.empty()) error["hint"] = hint;
  const auto replaced = nlohmann::ordered_json::error_handler_t::replace;
  return {status,
          "application/json",
          nlohmann::ordered_json{{"error", error}}.dump(1, ' ', false, replaced) + "\n",
          {}};
}

HttpReply json_reply(const nlohmann::ordered_json& document, int status) {
  return {status, "application/json", document.dump(1) + "\n", {}};
}

HttpReply guarded(const std::string& path, const std::function<HttpReply()>& make) {
  try {
    return make();
  } catch (const core::StorageError& error) {
    return told(507, error);
  } catch (const core::FileError& error) {
    return told(404, error);
  } catch (const core::ConfigError& error) {
    return told(400, error);
  } catch (const core::InputError& error) {
    return told(400, error);
  } catch (const core::Error& error) {
    return told(500, error);
  } catch (const std::bad_alloc&) {
    return error_reply(507, "out of memory");
  } catch (const std::exception& error) {
    spdlog::error("{}: {}", path, error.what());
    return error_reply(500, error.what());
  }
}

}  // namespace carillon::report::service
