#include "core/error.hpp"
#include "report/report.hpp"

#ifdef CARILLON_PAGE
// The page as the build bundled it (report/page), within the program.
#include CARILLON_PAGE_HASH
__asm__(
    ".section .rodata\n"
    ".global carillon_page_begin\n"
    ".global carillon_page_end\n"
    "carillon_page_begin:\n"
    ".incbin \"" CARILLON_PAGE
    "\"\n"
    "carillon_page_end:\n"
    ".previous\n");
extern "C" const char carillon_page_begin[];
extern "C" const char carillon_page_end[];
#endif

namespace carillon::report {

namespace {

#ifdef CARILLON_PAGE
std::string empty_page() {
  return {carillon_page_begin, carillon_page_end};
}
#else
std::string empty_page() {
  throw core::InputError(
      "this program was built without the page that reports are shown on",
      "install npm (Debian: npm), configure with -DCARILLON_REPORT=ON and build");
}
#endif

}  // namespace

std::string report_page(const nlohmann::ordered_json& report) {
  constexpr std::string_view mark = "/* report */";
  std::string page = empty_page();
  // Within an element for scripts, only these end it or change how it ends; JSON may write them
  // otherwise.
  std::string text = report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  return page.replace(page.rfind(mark), mark.size(), text);
}

}  // namespace carillon::report
