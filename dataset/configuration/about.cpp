#include "dataset/configuration/about.hpp"

#include <algorithm>
#include <cctype>

namespace carillon::dataset::configuration {

namespace {

/// The texts by their keys.
const std::vector<std::pair<const char*, std::string About::*>> texts = {
    {"description", &About::description},
    {"license", &About::license},
    {"url", &About::url},
    {"version", &About::version},
    {"published", &About::published},
    {"cite_as", &About::cite_as}};

bool is_date(const std::string& text) {
  const std::string form = "0000-00-00";
  return text.size() == form.size() &&
         std::equal(text.begin(), text.end(), form.begin(), [](char c, char like) {
           return like == '-' ? c == '-' : std::isdigit(static_cast<unsigned char>(c)) != 0;
         });
}

}  // namespace

About read_about(core::ConfigNode node) {
  About about;
  for (const auto& [key, member] : texts) about.*member = node.text(key, "");
  about.creators = node.texts("creator", std::vector<std::string>{});
  if (!about.published.empty() && !is_date(about.published)) {
    node.fail("published", "is not a date", "for example 2026-03-31");
  }
  if (!about.url.empty() && !about.url.starts_with("https://") &&
      !about.url.starts_with("http://")) {
    node.fail("url", "is not an address on the web", "it begins with https:// or http://");
  }
  return about;
}

nlohmann::json to_json(const About& about) {
  nlohmann::json said = nlohmann::json::object();
  for (const auto& [key, member] : texts) {
    if (!(about.*member).empty()) said[key] = about.*member;
  }
  if (!about.creators.empty()) said["creator"] = about.creators;
  return said;
}

About about_from(const nlohmann::json& said) {
  About about;
  for (const auto& [key, member] : texts) about.*member = said.value(key, "");
  about.creators = said.value("creator", std::vector<std::string>{});
  return about;
}

std::vector<std::string> missing_keys(const About& about) {
  std::vector<std::string> missing;
  for (const char* key : {"creator", "description", "license", "published", "url"}) {
    if (!to_json(about).contains(key)) missing.push_back(key);
  }
  return missing;
}

}  // namespace carillon::dataset::configuration
